#pragma once

#include <optional>

#include "frontend/ray_walk.h"

namespace grtx::frontend {

#if defined(__x86_64__)
/// Nothing on hosts whose AVX-512 lacks bytes (VBMI). others: for nodes that they do not take.
std::optional<WalkKernels> walk_kernels_avx512(unsigned slots, const WalkKernels& others);
#endif

}  // namespace grtx::frontend
