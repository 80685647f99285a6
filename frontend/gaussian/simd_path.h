// SPDX-License-Identifier: Apache-2.0
// Vector instructions for the tracer's inner loops, chosen at run time. Every path gives the same bits: the same
// roundings in the same order, without fused operations.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace grtx::frontend {

enum class SimdPath : std::uint8_t {
  portable,  ///< plain C++
  avx2,
  avx512,
};

/// The paths of `host` that do not exceed `limit`; "" is no limit. Throws Error{GRTX_SIMD} for an unknown name.
std::vector<SimdPath> limited_simd_paths(const std::vector<SimdPath>& host, const std::string& limit);

/// The paths that this host can run, slowest first, `portable` always included; none above the environment variable
/// GRTX_SIMD (portable, avx2 or avx512), which is read once. Throws Error when it names no path.
const std::vector<SimdPath>& available_simd_paths();
/// The fastest available path.
SimdPath best_simd_path();
const char* simd_path_name(SimdPath path);

}  // namespace grtx::frontend
