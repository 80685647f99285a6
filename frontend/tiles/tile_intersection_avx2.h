// SPDX-License-Identifier: Apache-2.0
// The tests of tile tracing on AVX2 instructions; on other machines than x86 there are none.
#pragma once

#include "grtx/frontend/tiles/tile_intersection.h"

namespace grtx::frontend {

#if defined(__x86_64__)
TileTests tile_tests_avx2();
void test_outlines_avx2(const TileStructure& structure, const TileRays& tile, TileCandidate* candidates,
                        std::size_t count);
#endif

}  // namespace grtx::frontend
