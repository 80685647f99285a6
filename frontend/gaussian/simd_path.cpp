#include "grtx/frontend/gaussian/simd_path.h"

namespace grtx::frontend {

const std::vector<SimdPath>& available_simd_paths() {
  static const std::vector<SimdPath> paths = [] {
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
