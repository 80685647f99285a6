// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/gaussian/simd_path.h"

#include <cstdlib>

#include "grtx/base/error.h"

namespace grtx::frontend {
namespace {

std::vector<SimdPath> host_simd_paths() {
  std::vector<SimdPath> found{SimdPath::portable};
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") != 0) {
    found.push_back(SimdPath::avx2);
    if (__builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512vl") != 0) {
      found.push_back(SimdPath::avx512);
    }
  }
#endif
  return found;
}

}  // namespace

std::vector<SimdPath> limited_simd_paths(const std::vector<SimdPath>& host, const std::string& limit) {
  if (limit.empty()) return host;
  for (const SimdPath last : {SimdPath::portable, SimdPath::avx2, SimdPath::avx512}) {
    if (limit != simd_path_name(last)) continue;
    std::vector<SimdPath> allowed;
    for (const SimdPath path : host) {
      if (path <= last) allowed.push_back(path);
    }
    return allowed;
  }
  throw Error("GRTX_SIMD", limit, "must be portable, avx2 or avx512");
}

const std::vector<SimdPath>& available_simd_paths() {
  static const std::vector<SimdPath> paths = [] {
    const char* limit = std::getenv("GRTX_SIMD");
    return limited_simd_paths(host_simd_paths(), limit != nullptr ? limit : "");
  }();
  return paths;
}

SimdPath best_simd_path() { return available_simd_paths().back(); }

const char* simd_path_name(SimdPath path) {
  switch (path) {
    case SimdPath::portable:
      return "portable";
    case SimdPath::avx2:
      return "avx2";
    case SimdPath::avx512:
      return "avx512";
  }
  return "";
}

}  // namespace grtx::frontend
