// The tests of tile tracing on AVX2 instructions; on other machines than x86 there are none.
#pragma once

#include "frontend/tile_tests.h"

namespace grtx::frontend {

#if defined(__x86_64__)
TileTests tile_tests_avx2();
#endif

}  // namespace grtx::frontend
