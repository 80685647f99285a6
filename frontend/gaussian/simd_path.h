// Which vector instructions the tracer's inner loops use. Chosen at run time; every path gives the same bits: the same
// roundings in the same order, nothing fused.
#pragma once

#include <cstdint>
#include <vector>

namespace grtx::frontend {

enum class SimdPath : std::uint8_t {
  portable,  ///< plain C++
  avx2,
  avx512,
};

/// The paths that this host can run, slowest first; `portable` always.
const std::vector<SimdPath>& available_simd_paths();
/// The last of them.
SimdPath best_simd_path();
const char* simd_path_name(SimdPath path);

}  // namespace grtx::frontend
