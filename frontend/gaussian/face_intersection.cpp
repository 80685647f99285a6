// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/gaussian/face_intersection.h"

#include <cmath>
#include <limits>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace grtx::frontend {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

Interval test_portable(const glm::vec3& peak, const glm::vec3& direction, const FaceSlabs& faces,
                       std::uint32_t& entry_face, std::uint32_t& exit_face) {
  float enter = -kInfinity;
  float exit = kInfinity;
  for (unsigned i = 0; i < faces.pairs; ++i) {
    const float s = (faces.x[i] * peak.x + faces.y[i] * peak.y) + faces.z[i] * peak.z;
    const float v = (faces.x[i] * direction.x + faces.y[i] * direction.y) + faces.z[i] * direction.z;
    if (v == 0.0f) {
      if (std::fabs(s) > faces.distance[i]) return {0.0f, -1.0f};
      continue;
    }
    // Moving along v > 0 the ray enters through the face whose normal points against it.
    const float towards = v > 0.0f ? -faces.distance[i] : faces.distance[i];
    const float e_near = (towards - s) / v;
    const float e_far = (-towards - s) / v;
    if (e_near > enter) {
      enter = e_near;
      entry_face = v > 0.0f ? faces.negative[i] : faces.positive[i];
    }
    if (e_far < exit) {
      exit = e_far;
      exit_face = v > 0.0f ? faces.positive[i] : faces.negative[i];
    }
  }
  return {enter, exit};
}

#if defined(__x86_64__)

/// The first pair whose value equals the largest (or smallest) one, which is in all lanes of `best`.
[[gnu::target("avx2,bmi"), gnu::always_inline]] inline unsigned first_equal(const float* values, unsigned blocks,
                                                                            __m256 best) {
  for (unsigned b = 0; b < blocks; ++b) {
    const int equal = _mm256_movemask_ps(
        _mm256_cmp_ps(_mm256_load_ps(values + std::size_t{b} * FaceSlabs::kLanes), best, _CMP_EQ_OQ));
    if (equal != 0) return b * FaceSlabs::kLanes + static_cast<unsigned>(__builtin_ctz(static_cast<unsigned>(equal)));
  }
  return 0;  // not reached: the best value is one of them
}

[[gnu::target("avx2,bmi")]] Interval test_avx2(const glm::vec3& peak, const glm::vec3& direction,
                                               const FaceSlabs& faces, std::uint32_t& entry_face,
                                               std::uint32_t& exit_face) {
  const unsigned blocks = (faces.pairs + FaceSlabs::kLanes - 1) / FaceSlabs::kLanes;
  const __m256 px = _mm256_set1_ps(peak.x), py = _mm256_set1_ps(peak.y), pz = _mm256_set1_ps(peak.z);
  const __m256 dx = _mm256_set1_ps(direction.x), dy = _mm256_set1_ps(direction.y), dz = _mm256_set1_ps(direction.z);
  const __m256 sign = _mm256_set1_ps(-0.0f), zero = _mm256_setzero_ps();
  const __m256 nothing_near = _mm256_set1_ps(-kInfinity), nothing_far = _mm256_set1_ps(kInfinity);
  __m256 nearest = nothing_near, farthest = nothing_far;
  __m256 outside = zero;
  alignas(32) float enters[FaceSlabs::kMaxPairs];
  alignas(32) float exits[FaceSlabs::kMaxPairs];
  alignas(32) float speeds[FaceSlabs::kMaxPairs];
  for (unsigned b = 0; b < blocks; ++b) {
    const std::size_t at = std::size_t{b} * FaceSlabs::kLanes;
    const __m256 nx = _mm256_load_ps(&faces.x[at]);
    const __m256 ny = _mm256_load_ps(&faces.y[at]);
    const __m256 nz = _mm256_load_ps(&faces.z[at]);
    const __m256 distance = _mm256_load_ps(&faces.distance[at]);
    const __m256 s = _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(nx, px), _mm256_mul_ps(ny, py)), _mm256_mul_ps(nz, pz));
    const __m256 v = _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(nx, dx), _mm256_mul_ps(ny, dy)), _mm256_mul_ps(nz, dz));
    const __m256 parallel = _mm256_cmp_ps(v, zero, _CMP_EQ_OQ);
    outside =
        _mm256_or_ps(outside, _mm256_and_ps(parallel, _mm256_cmp_ps(_mm256_andnot_ps(sign, s), distance, _CMP_GT_OQ)));
    const __m256 towards = _mm256_xor_ps(distance, _mm256_and_ps(sign, _mm256_cmp_ps(v, zero, _CMP_GT_OQ)));
    const __m256 e_near = _mm256_div_ps(_mm256_sub_ps(towards, s), v);
    const __m256 e_far = _mm256_div_ps(_mm256_sub_ps(_mm256_xor_ps(towards, sign), s), v);
    // A parallel pair or a NaN leaves the interval alone.
    const __m256 no_near = _mm256_or_ps(parallel, _mm256_cmp_ps(e_near, e_near, _CMP_UNORD_Q));
    const __m256 no_far = _mm256_or_ps(parallel, _mm256_cmp_ps(e_far, e_far, _CMP_UNORD_Q));
    const __m256 enter = _mm256_blendv_ps(e_near, nothing_near, no_near);
    const __m256 exit = _mm256_blendv_ps(e_far, nothing_far, no_far);
    nearest = _mm256_max_ps(nearest, enter);
    farthest = _mm256_min_ps(farthest, exit);
    _mm256_store_ps(enters + at, enter);
    _mm256_store_ps(exits + at, exit);
    _mm256_store_ps(speeds + at, v);
  }
  if (_mm256_movemask_ps(outside) != 0) return {0.0f, -1.0f};
  nearest = _mm256_max_ps(nearest, _mm256_permute2f128_ps(nearest, nearest, 1));
  nearest = _mm256_max_ps(nearest, _mm256_permute_ps(nearest, 0x4E));
  nearest = _mm256_max_ps(nearest, _mm256_permute_ps(nearest, 0xB1));
  farthest = _mm256_min_ps(farthest, _mm256_permute2f128_ps(farthest, farthest, 1));
  farthest = _mm256_min_ps(farthest, _mm256_permute_ps(farthest, 0x4E));
  farthest = _mm256_min_ps(farthest, _mm256_permute_ps(farthest, 0xB1));
  const unsigned in = first_equal(enters, blocks, nearest);
  const unsigned out = first_equal(exits, blocks, farthest);
  if (enters[in] > -kInfinity) entry_face = speeds[in] > 0.0f ? faces.negative[in] : faces.positive[in];
  if (exits[out] < kInfinity) exit_face = speeds[out] > 0.0f ? faces.positive[out] : faces.negative[out];
  return {enters[in], exits[out]};
}

#endif

}  // namespace

FaceTest face_test(SimdPath path) {
#if defined(__x86_64__)
  if (path != SimdPath::portable) return test_avx2;  // twenty faces are ten pairs: wider vectors would stay half empty
#endif
  static_cast<void>(path);
  return test_portable;
}

}  // namespace grtx::frontend
