// The walk's inner loops in AVX2.
#pragma once

#include "grtx/frontend/tracer/walk_kernels.h"

namespace grtx::frontend {

#if defined(__x86_64__)
/// The host must have AVX2.
WalkKernels walk_kernels_avx2(const InternalLayout& layout);
#endif

}  // namespace grtx::frontend
