// Which vector instructions the tracer's inner loops use. Chosen at run time; every path gives the same bits: the same
// roundings in the same order, nothing fused.
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

/// What a host with these paths may use when it is told no more than `limit`: the paths up to it. A limit that the host
/// lacks leaves what it has below; "" is no limit. Throws Error{GRTX_SIMD} for a name that is no path's.
std::vector<SimdPath> limited_simd_paths(const std::vector<SimdPath>& host, const std::string& limit);

/// The paths that this host can run, slowest first, `portable` always; none above the environment's GRTX_SIMD
/// (portable, avx2 or avx512), which is read once. Throws Error when that names no path.
const std::vector<SimdPath>& available_simd_paths();
/// The last of them.
SimdPath best_simd_path();
const char* simd_path_name(SimdPath path);

}  // namespace grtx::frontend
