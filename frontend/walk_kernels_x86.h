#pragma once

#include "frontend/walk_kernels.h"

namespace grtx::frontend {

#if defined(__x86_64__)
WalkKernels walk_kernels_avx2(unsigned slots);
WalkKernels walk_kernels_avx512(unsigned slots);
#endif

}  // namespace grtx::frontend
