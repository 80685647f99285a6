// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tiles/tile_intersection_avx2.h"

#if defined(__x86_64__)

#include <immintrin.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <limits>

#include "grtx/frontend/tiles/tile_columns_avx2.h"
#include "grtx/frontend/tiles/tile_margins.h"

namespace grtx::frontend {
namespace {

/// Coefficients as in frontend/tiles/tile_intersection.cpp.
struct ConicCoefficients {
  float one, u, v, uu, uv, vv, slack;
};

/// Mask of the rays of the `wanted` vectors that are inside.
[[gnu::target("avx2"), gnu::always_inline]] inline std::uint64_t rays_inside(const ConicCoefficients& c,
                                                                             const TileRays& tile,
                                                                             std::uint64_t wanted) {
  const __m256 one = _mm256_set1_ps(c.one), uu = _mm256_set1_ps(c.uu), vv = _mm256_set1_ps(c.vv);
  const __m256 u1 = _mm256_set1_ps(c.u), uv = _mm256_set1_ps(c.uv), v1 = _mm256_set1_ps(c.v);
  const __m256 limit = _mm256_set1_ps(c.slack);
  std::uint64_t rays = 0;
  for (; wanted != 0; wanted &= wanted - 1) {
    const auto i = static_cast<unsigned>(std::countr_zero(wanted));
    const __m256 u = _mm256_load_ps(&tile.u[std::size_t{i} * kTileLanes]);
    const __m256 v = _mm256_load_ps(&tile.v[std::size_t{i} * kTileLanes]);
    const __m256 across = _mm256_add_ps(_mm256_mul_ps(u, _mm256_add_ps(_mm256_mul_ps(uu, u), u1)), one);
    const __m256 down = _mm256_mul_ps(v, _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(vv, v), v1), _mm256_mul_ps(uv, u)));
    const __m256 inside = _mm256_cmp_ps(_mm256_add_ps(across, down), limit, _CMP_NGT_UQ);
    rays |= static_cast<std::uint64_t>(static_cast<unsigned>(_mm256_movemask_ps(inside))) << (i * kTileLanes);
  }
  return rays;
}

/// Tests one Gaussian: the four lanes hold the values for axis, right, down and mean.
[[gnu::target("avx2")]] std::uint64_t test_outline(const TileGaussian& g, const TileRays& tile, std::uint64_t wanted) {
  const float mean[3] = {g.mean.x - tile.origin.x, g.mean.y - tile.origin.y, g.mean.z - tile.origin.z};
  const __m128 x = _mm_insert_ps(_mm_load_ps(tile.frame[0]), _mm_set_ss(mean[0]), 0x30);
  const __m128 y = _mm_insert_ps(_mm_load_ps(tile.frame[1]), _mm_set_ss(mean[1]), 0x30);
  const __m128 z = _mm_insert_ps(_mm_load_ps(tile.frame[2]), _mm_set_ss(mean[2]), 0x30);
  __m128 l[3], a[3];
  for (int i = 0; i < 3; ++i) {
    const glm::vec3& row = g.to_unit[i];
    l[i] = _mm_add_ps(_mm_add_ps(_mm_mul_ps(_mm_set1_ps(row.x), x), _mm_mul_ps(_mm_set1_ps(row.y), y)),
                      _mm_mul_ps(_mm_set1_ps(row.z), z));
    a[i] = _mm_permute_ps(l[i], 0xFF);
  }
  const __m128 wx = _mm_sub_ps(_mm_mul_ps(a[1], l[2]), _mm_mul_ps(a[2], l[1]));
  const __m128 wy = _mm_sub_ps(_mm_mul_ps(a[2], l[0]), _mm_mul_ps(a[0], l[2]));
  const __m128 wz = _mm_sub_ps(_mm_mul_ps(a[0], l[1]), _mm_mul_ps(a[1], l[0]));
  const __m128 ww = _mm_add_ps(_mm_add_ps(_mm_mul_ps(wx, wx), _mm_mul_ps(wy, wy)), _mm_mul_ps(wz, wz));
  const __m128 ll = _mm_add_ps(_mm_add_ps(_mm_mul_ps(l[0], l[0]), _mm_mul_ps(l[1], l[1])), _mm_mul_ps(l[2], l[2]));
  constexpr int kNext = 0xC9;  // right, down, axis
  const __m128 cross_w =
      _mm_add_ps(_mm_add_ps(_mm_mul_ps(wx, _mm_permute_ps(wx, kNext)), _mm_mul_ps(wy, _mm_permute_ps(wy, kNext))),
                 _mm_mul_ps(wz, _mm_permute_ps(wz, kNext)));
  const __m128 cross_l = _mm_add_ps(
      _mm_add_ps(_mm_mul_ps(l[0], _mm_permute_ps(l[0], kNext)), _mm_mul_ps(l[1], _mm_permute_ps(l[1], kNext))),
      _mm_mul_ps(l[2], _mm_permute_ps(l[2], kNext)));
  alignas(16) float same[4], mixed[4], w2[4], l2[4];
  const float place[3] = {_mm_cvtss_f32(a[0]), _mm_cvtss_f32(a[1]), _mm_cvtss_f32(a[2])};
  _mm_store_ps(same, _mm_sub_ps(ww, ll));
  const __m128 product = _mm_sub_ps(cross_w, cross_l);
  _mm_store_ps(mixed, _mm_add_ps(product, product));
  _mm_store_ps(w2, ww);
  _mm_store_ps(l2, ll);
  const float slack = outline_slack(tile, g.norm, mean, place, w2, l2);
  return rays_inside({same[0], mixed[0], mixed[2], same[1], mixed[1], same[2], slack}, tile, wanted);
}

constexpr std::size_t kConicBatch = 8;

struct LaneVectors {
  __m256 x, y, z;
};

[[gnu::target("avx2"), gnu::always_inline]] inline __m256 lane_dot(const LaneVectors& a, const LaneVectors& b) {
  return _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(a.x, b.x), _mm256_mul_ps(a.y, b.y)), _mm256_mul_ps(a.z, b.z));
}
[[gnu::target("avx2"), gnu::always_inline]] inline LaneVectors lane_cross(const LaneVectors& a, const LaneVectors& b) {
  return {_mm256_sub_ps(_mm256_mul_ps(a.y, b.z), _mm256_mul_ps(a.z, b.y)),
          _mm256_sub_ps(_mm256_mul_ps(a.z, b.x), _mm256_mul_ps(a.x, b.z)),
          _mm256_sub_ps(_mm256_mul_ps(a.x, b.y), _mm256_mul_ps(a.y, b.x))};
}
[[gnu::target("avx2"), gnu::always_inline]] inline __m256 sum_of_sizes(const LaneVectors& a) {
  const __m256 sign = _mm256_set1_ps(-0.0f);
  return _mm256_add_ps(_mm256_add_ps(_mm256_andnot_ps(sign, a.x), _mm256_andnot_ps(sign, a.y)),
                       _mm256_andnot_ps(sign, a.z));
}

/// Conics of eight Gaussians at once, with the same order of operations as for one.
struct alignas(32) ConicBatch {
  float one[kConicBatch], u[kConicBatch], v[kConicBatch], uu[kConicBatch], uv[kConicBatch], vv[kConicBatch],
      slack[kConicBatch];
};

[[gnu::target("avx2")]] void make_conics(const float* const* g, const TileRays& tile, ConicBatch& conics) {
  static_assert(offsetof(TileGaussian, norm) == 12 && offsetof(TileGaussian, to_unit) == 16);
  __m256 columns[16];
  for (std::size_t i = 0; i < 4; ++i) load_columns(g, 4 * i, columns + 4 * i);
  const LaneVectors mean = {_mm256_sub_ps(columns[0], _mm256_set1_ps(tile.origin.x)),
                            _mm256_sub_ps(columns[1], _mm256_set1_ps(tile.origin.y)),
                            _mm256_sub_ps(columns[2], _mm256_set1_ps(tile.origin.z))};
  const __m256 norm = columns[3];
  const LaneVectors rows[3] = {{columns[4], columns[5], columns[6]},
                               {columns[7], columns[8], columns[9]},
                               {columns[10], columns[11], columns[12]}};
  const LaneVectors a = {lane_dot(rows[0], mean), lane_dot(rows[1], mean), lane_dot(rows[2], mean)};
  LaneVectors l[3], w[3];
  __m256 ww[3], ll[3];
  for (int c = 0; c < 3; ++c) {
    const LaneVectors column = {_mm256_set1_ps(tile.frame[0][c]), _mm256_set1_ps(tile.frame[1][c]),
                                _mm256_set1_ps(tile.frame[2][c])};
    l[c] = {lane_dot(rows[0], column), lane_dot(rows[1], column), lane_dot(rows[2], column)};
    w[c] = lane_cross(a, l[c]);
    ww[c] = lane_dot(w[c], w[c]);
    ll[c] = lane_dot(l[c], l[c]);
  }
  _mm256_store_ps(conics.one, _mm256_sub_ps(ww[0], ll[0]));
  _mm256_store_ps(conics.uu, _mm256_sub_ps(ww[1], ll[1]));
  _mm256_store_ps(conics.vv, _mm256_sub_ps(ww[2], ll[2]));
  const __m256 two = _mm256_set1_ps(2.0f);
  _mm256_store_ps(conics.u, _mm256_mul_ps(two, _mm256_sub_ps(lane_dot(w[0], w[1]), lane_dot(l[0], l[1]))));
  _mm256_store_ps(conics.uv, _mm256_mul_ps(two, _mm256_sub_ps(lane_dot(w[1], w[2]), lane_dot(l[1], l[2]))));
  _mm256_store_ps(conics.v, _mm256_mul_ps(two, _mm256_sub_ps(lane_dot(w[2], w[0]), lane_dot(l[2], l[0]))));
  // outline_slack()
  const __m256 extent2 = _mm256_set1_ps(tile.extent2), share = _mm256_set1_ps(kOutlineSlack);
  const __m256 size_w = _mm256_add_ps(ww[0], _mm256_mul_ps(extent2, _mm256_add_ps(ww[1], ww[2])));
  const __m256 size_l = _mm256_add_ps(ll[0], _mm256_mul_ps(extent2, _mm256_add_ps(ll[1], ll[2])));
  const __m256 usable = _mm256_and_ps(_mm256_cmp_ps(size_l, _mm256_set1_ps(1e-30f), _CMP_GT_OQ),
                                      _mm256_cmp_ps(size_w, _mm256_set1_ps(1e30f), _CMP_LT_OQ));
  const __m256 place = _mm256_add_ps(sum_of_sizes(a), _mm256_set1_ps(1.0f));
  const __m256 length = _mm256_sqrt_ps(_mm256_mul_ps(_mm256_set1_ps(3.0f), size_l));
  const __m256 error =
      _mm256_mul_ps(_mm256_mul_ps(share, norm), _mm256_add_ps(_mm256_mul_ps(sum_of_sizes(mean), length), place));
  const __m256 slack =
      _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(_mm256_mul_ps(two, length), error), _mm256_mul_ps(error, error)),
                    _mm256_mul_ps(share, _mm256_add_ps(size_w, size_l)));
  const __m256 everything = _mm256_set1_ps(std::numeric_limits<float>::infinity());
  _mm256_store_ps(conics.slack, _mm256_blendv_ps(everything, slack, usable));
}

constexpr std::size_t kEnoughConics = 3;  ///< fewer are faster one by one

}  // namespace

[[gnu::target("avx2")]] void test_outlines_avx2(const TileStructure& structure, const TileRays& tile,
                                                TileCandidate* candidates, std::size_t count) {
  if (!tile.narrow) return tile_tests(SimdPath::portable).outlines(structure, tile, candidates, count);
  while (count >= kEnoughConics) {
    const std::size_t taken = std::min(count, kConicBatch);
    const float* gaussians[kConicBatch];
    for (std::size_t i = 0; i < kConicBatch; ++i) {
      gaussians[i] = &structure.gaussian(candidates[std::min(i, taken - 1)].gaussian).mean.x;
    }
    ConicBatch c;
    make_conics(gaussians, tile, c);
    for (std::size_t i = 0; i < taken; ++i) {
      candidates[i].rays =
          rays_inside({c.one[i], c.u[i], c.v[i], c.uu[i], c.uv[i], c.vv[i], c.slack[i]}, tile, candidates[i].rays);
    }
    candidates += taken;
    count -= taken;
  }
  for (std::size_t i = 0; i < count; ++i) {
    candidates[i].rays = test_outline(structure.gaussian(candidates[i].gaussian), tile, candidates[i].rays);
  }
}

}  // namespace grtx::frontend

#endif
