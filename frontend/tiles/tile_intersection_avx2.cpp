// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tiles/tile_intersection_avx2.h"

#if defined(__x86_64__)

#include <immintrin.h>

#include <algorithm>
#include <cstddef>
#include <limits>

#include "grtx/frontend/gaussian/gaussian_math.h"
#include "grtx/frontend/tiles/tile_columns_avx2.h"
#include "grtx/frontend/tiles/tile_margins.h"

namespace grtx::frontend {
namespace {

constexpr float kUnbounded = std::numeric_limits<float>::infinity();

[[gnu::target("avx2"), gnu::always_inline]] inline __m256 bounds_avx2(const TileNode& node, int axis,
                                                                      const std::uint8_t* values) {
  const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(values));
  const __m256 steps = _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(bytes));
  return _mm256_add_ps(_mm256_set1_ps(node.origin[axis]), _mm256_mul_ps(steps, _mm256_set1_ps(node.step[axis])));
}

/// Largest or smallest extent of eight boxes (bounds relative to the origin) along n.
[[gnu::target("avx2"), gnu::always_inline]] inline __m256 reach_avx2(const float (*relative)[kTileNodeWidth],
                                                                     const float* n, bool most) {
  const __m256 x = _mm256_mul_ps(_mm256_set1_ps(n[0]), _mm256_load_ps(relative[(n[0] > 0.0f) == most ? 1 : 0]));
  const __m256 y = _mm256_mul_ps(_mm256_set1_ps(n[1]), _mm256_load_ps(relative[(n[1] > 0.0f) == most ? 3 : 2]));
  const __m256 z = _mm256_mul_ps(_mm256_set1_ps(n[2]), _mm256_load_ps(relative[(n[2] > 0.0f) == most ? 5 : 4]));
  return _mm256_add_ps(_mm256_add_ps(x, y), z);
}

/// Columns or rows covered, as whole numbers; inverse_near and inverse_far: of the depth.
[[gnu::target("avx2"), gnu::always_inline]] inline void cover_avx2(__m256 low, __m256 high, __m256 inverse_near,
                                                                   __m256 inverse_far, float scale, float margin,
                                                                   __m256& first, __m256& last) {
  const __m256 scales = _mm256_set1_ps(scale), middle = _mm256_set1_ps(0.5f * (kTileEdge - 1));
  const __m256 a = _mm256_min_ps(_mm256_mul_ps(low, inverse_near), _mm256_mul_ps(low, inverse_far));
  const __m256 b = _mm256_max_ps(_mm256_mul_ps(high, inverse_near), _mm256_mul_ps(high, inverse_far));
  const __m256 from = _mm256_add_ps(_mm256_mul_ps(a, scales), middle);
  const __m256 to = _mm256_add_ps(_mm256_mul_ps(b, scales), middle);
  const __m256 slack =
      _mm256_add_ps(_mm256_set1_ps(margin), _mm256_mul_ps(_mm256_sub_ps(to, from), _mm256_set1_ps(kGridSlack)));
  first = _mm256_ceil_ps(_mm256_max_ps(_mm256_sub_ps(from, slack), _mm256_setzero_ps()));
  last = _mm256_floor_ps(_mm256_min_ps(_mm256_add_ps(to, slack), _mm256_set1_ps(kTileEdge - 1)));
}

/// Where the rays of a tile are inside eight boxes, along all axes; `relative`: the bounds from the tile's origin.
[[gnu::target("avx2"), gnu::always_inline]] inline void slabs_avx2(const TileNode& node, const TileRays& tile,
                                                                   float (*relative)[kTileNodeWidth], __m256& near_t,
                                                                   __m256& far_t) {
  for (int axis = 0; axis < 3; ++axis) {
    const __m256 origin = _mm256_set1_ps(tile.origin[axis]);
    const __m256 low = _mm256_sub_ps(bounds_avx2(node, axis, node.lower[axis]), origin);
    const __m256 high = _mm256_sub_ps(bounds_avx2(node, axis, node.upper[axis]), origin);
    _mm256_store_ps(relative[2 * axis], low);
    _mm256_store_ps(relative[2 * axis + 1], high);
    const __m256 least = _mm256_set1_ps(tile.inverse_min[axis]), most = _mm256_set1_ps(tile.inverse_max[axis]);
    __m256 first, last;
    if (tile.inverse_min[axis] > 0.0f || tile.inverse_max[axis] < 0.0f) {
      const __m256 near = tile.inverse_min[axis] > 0.0f ? low : high;
      const __m256 far = tile.inverse_min[axis] > 0.0f ? high : low;
      first = _mm256_min_ps(_mm256_mul_ps(near, least), _mm256_mul_ps(near, most));
      last = _mm256_max_ps(_mm256_mul_ps(far, least), _mm256_mul_ps(far, most));
    } else {
      const __m256 a = _mm256_mul_ps(low, least), b = _mm256_mul_ps(low, most);
      const __m256 c = _mm256_mul_ps(high, least), d = _mm256_mul_ps(high, most);
      first = _mm256_min_ps(_mm256_min_ps(a, b), _mm256_min_ps(c, d));
      last = _mm256_max_ps(_mm256_max_ps(a, b), _mm256_max_ps(c, d));
    }
    near_t = _mm256_max_ps(first, near_t);  // a NaN leaves the bound alone
    far_t = _mm256_min_ps(last, far_t);
  }
}

/// The vectors of a tile (4x2 pixels each) that contain the covered pixels; all of them where the grid is not usable.
[[gnu::target("avx2"), gnu::always_inline]] inline __m256i covered_vectors_avx2(__m256 left, __m256 right, __m256 top,
                                                                                __m256 bottom, __m256 usable) {
  const __m256i ones = _mm256_set1_epi32(0xFF), two = _mm256_set1_epi32(-2);
  const __m256i first_row = _mm256_and_si256(_mm256_cvttps_epi32(top), two);
  const __m256i last_row = _mm256_and_si256(_mm256_cvttps_epi32(bottom), two);
  const __m256i rows = _mm256_and_si256(_mm256_sllv_epi32(ones, first_row),
                                        _mm256_srlv_epi32(ones, _mm256_sub_epi32(_mm256_set1_epi32(6), last_row)));
  const __m256 four = _mm256_set1_ps(4.0f);
  const __m256i left_half = _mm256_castps_si256(_mm256_cmp_ps(left, four, _CMP_LT_OQ));
  const __m256i right_half = _mm256_castps_si256(_mm256_cmp_ps(right, four, _CMP_GE_OQ));
  const __m256i columns = _mm256_or_si256(_mm256_and_si256(left_half, _mm256_set1_epi32(0x55)),
                                          _mm256_and_si256(right_half, _mm256_set1_epi32(0xAA)));
  const __m256i covered = _mm256_and_si256(rows, columns);
  return _mm256_blendv_epi8(ones, covered, _mm256_castps_si256(usable));
}

[[gnu::target("avx2")]] unsigned test_node_avx2(const TileNode& node, const TileRays& tile, const TileDepths& depths,
                                                std::uint32_t bucket, TileNodeHits& hits) {
  alignas(32) float relative[6][kTileNodeWidth];
  __m256 near_t = _mm256_set1_ps(-kUnbounded), far_t = _mm256_set1_ps(kUnbounded);
  slabs_avx2(node, tile, relative, near_t, far_t);
  const __m256 zero = _mm256_setzero_ps();
  const __m256 entry = _mm256_mul_ps(_mm256_max_ps(near_t, zero), _mm256_set1_ps(1.0f - kSlabSlack));
  const __m256 exit = _mm256_mul_ps(far_t, _mm256_set1_ps(1.0f + kSlabSlack));
  const __m256i steps = _mm256_sra_epi32(_mm256_sub_epi32(_mm256_castps_si256(entry), _mm256_set1_epi32(depths.first)),
                                         _mm_cvtsi32_si128(depths.shift));
  const __m256i buckets = _mm256_add_epi32(
      _mm256_min_epi32(steps, _mm256_set1_epi32(static_cast<int>(TileDepths::kBuckets) - 2)), _mm256_set1_epi32(1));
  _mm256_store_si256(reinterpret_cast<__m256i*>(hits.bucket),
                     _mm256_max_epi32(buckets, _mm256_set1_epi32(static_cast<int>(bucket))));
  __m256 outside = _mm256_cmp_ps(entry, exit, _CMP_GT_OQ);
  if (tile.narrow && !tile.grid) {  // the grid test is tighter
    for (const float* n : tile.planes) {
      outside = _mm256_or_ps(outside, _mm256_cmp_ps(reach_avx2(relative, n, true), zero, _CMP_LT_OQ));
    }
  }
  unsigned mask = ~static_cast<unsigned>(_mm256_movemask_ps(outside)) & node.used;
  _mm256_store_si256(reinterpret_cast<__m256i*>(hits.vectors), _mm256_set1_epi32(0xFF));
  if (!tile.grid || mask == 0) return mask;
  const __m256 near = reach_avx2(relative, tile.along, false), far = reach_avx2(relative, tile.along, true);
  const __m256 usable =
      _mm256_and_ps(_mm256_cmp_ps(near, zero, _CMP_GT_OQ), _mm256_cmp_ps(far, _mm256_add_ps(near, near), _CMP_LE_OQ));
  const __m256 inverse_near = _mm256_div_ps(_mm256_set1_ps(1.0f), near);
  const __m256 inverse_far = _mm256_div_ps(_mm256_set1_ps(1.0f), far);
  __m256 left, right, top, bottom;
  cover_avx2(reach_avx2(relative, tile.across, false), reach_avx2(relative, tile.across, true), inverse_near,
             inverse_far, tile.scale[0], tile.margin, left, right);
  cover_avx2(reach_avx2(relative, tile.down, false), reach_avx2(relative, tile.down, true), inverse_near, inverse_far,
             tile.scale[1], tile.margin, top, bottom);
  const __m256 between = _mm256_or_ps(_mm256_cmp_ps(left, right, _CMP_GT_OQ), _mm256_cmp_ps(top, bottom, _CMP_GT_OQ));
  mask &= ~static_cast<unsigned>(_mm256_movemask_ps(_mm256_and_ps(usable, between)));
  _mm256_store_si256(reinterpret_cast<__m256i*>(hits.vectors), covered_vectors_avx2(left, right, top, bottom, usable));
  return mask;
}

/// exp_negative() of four numbers.
[[gnu::target("avx2"), gnu::always_inline]] inline __m128 exp_negative_avx2(__m128 x) {
  const __m256d value = _mm256_cvtps_pd(x);
  const __m256d scaled = _mm256_mul_pd(value, _mm256_set1_pd(1.4426950408889634));
  const __m128i n = _mm256_cvttpd_epi32(_mm256_sub_pd(scaled, _mm256_set1_pd(0.5)));
  const __m256d r = _mm256_sub_pd(value, _mm256_mul_pd(_mm256_cvtepi32_pd(n), _mm256_set1_pd(0.6931471805599453)));
  __m256d p = _mm256_set1_pd(1.0 / 362880.0);
  for (const double c : {1.0 / 40320.0, 1.0 / 5040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0}) {
    p = _mm256_add_pd(_mm256_mul_pd(p, r), _mm256_set1_pd(c));
  }
  const __m256i power = _mm256_slli_epi64(_mm256_add_epi64(_mm256_cvtepi32_epi64(n), _mm256_set1_epi64x(1023)), 52);
  return _mm256_cvtpd_ps(_mm256_mul_pd(p, _mm256_castsi256_pd(power)));
}

/// Short names of the instructions that the hit test uses.
struct Lanes {
  using Float = __m256;
  [[gnu::target("avx2"), gnu::always_inline]] static Float load(const float* p) { return _mm256_load_ps(p); }
  [[gnu::target("avx2"), gnu::always_inline]] static void store(float* p, Float a) { _mm256_store_ps(p, a); }
  [[gnu::target("avx2"), gnu::always_inline]] static Float all(float a) { return _mm256_set1_ps(a); }
  [[gnu::target("avx2"), gnu::always_inline]] static Float add(Float a, Float b) { return _mm256_add_ps(a, b); }
  [[gnu::target("avx2"), gnu::always_inline]] static Float sub(Float a, Float b) { return _mm256_sub_ps(a, b); }
  [[gnu::target("avx2"), gnu::always_inline]] static Float mul(Float a, Float b) { return _mm256_mul_ps(a, b); }
  [[gnu::target("avx2"), gnu::always_inline]] static Float div(Float a, Float b) { return _mm256_div_ps(a, b); }
  [[gnu::target("avx2"), gnu::always_inline]] static Float sqrt(Float a) { return _mm256_sqrt_ps(a); }
  [[gnu::target("avx2"), gnu::always_inline]] static Float min(Float a, Float b) { return _mm256_min_ps(a, b); }
  [[gnu::target("avx2"), gnu::always_inline]] static Float max(Float a, Float b) { return _mm256_max_ps(a, b); }
  [[gnu::target("avx2"), gnu::always_inline]] static Float both(Float a, Float b) { return _mm256_and_ps(a, b); }
  [[gnu::target("avx2"), gnu::always_inline]] static Float negative(Float a) { return _mm256_xor_ps(all(-0.0f), a); }
  [[gnu::target("avx2"), gnu::always_inline]] static Float size(Float a) { return _mm256_andnot_ps(all(-0.0f), a); }
  /// b where the sign of `choice` is set, else a.
  [[gnu::target("avx2"), gnu::always_inline]] static Float choose(Float a, Float b, Float choice) {
    return _mm256_blendv_ps(a, b, choice);
  }
  [[gnu::target("avx2"), gnu::always_inline]] static Float less(Float a, Float b) {
    return _mm256_cmp_ps(a, b, _CMP_LT_OQ);
  }
  [[gnu::target("avx2"), gnu::always_inline]] static Float at_most(Float a, Float b) {
    return _mm256_cmp_ps(a, b, _CMP_LE_OQ);
  }
  [[gnu::target("avx2"), gnu::always_inline]] static unsigned mask(Float a) {
    return static_cast<unsigned>(_mm256_movemask_ps(a));
  }
  [[gnu::target("avx2"), gnu::always_inline]] static Float exp_negative(Float a) {
    return _mm256_set_m128(exp_negative_avx2(_mm256_extractf128_ps(a, 1)),
                           exp_negative_avx2(_mm256_castps256_ps128(a)));
  }
};

using LaneFloat = Lanes::Float;

struct LaneVector {
  LaneFloat x, y, z;
};

[[gnu::target("avx2"), gnu::always_inline]] inline LaneFloat dot_lanes(const LaneVector& a, const LaneVector& b) {
  return Lanes::add(Lanes::add(Lanes::mul(a.x, b.x), Lanes::mul(a.y, b.y)), Lanes::mul(a.z, b.z));
}

/// One axis of slab_interval(): near and far are chosen by the sign of the reciprocal direction. low, high: relative.
[[gnu::target("avx2"), gnu::always_inline]] inline void clip_axis(LaneFloat low, LaneFloat high, LaneFloat inverse,
                                                                  LaneFloat& enter, LaneFloat& exit) {
  const LaneFloat a = Lanes::mul(low, inverse), b = Lanes::mul(high, inverse);
  enter = Lanes::max(Lanes::choose(a, b, inverse), enter);
  exit = Lanes::min(Lanes::choose(b, a, inverse), exit);
}

/// Inputs of eight lanes; mean and box are relative to the origin.
struct LaneInputs {
  LaneVector direction, inverse;
  LaneFloat inverse_length2;
  LaneVector mean;
  LaneVector rows[3];
  LaneFloat kappa2, opacity;
  LaneVector low, high;
};

[[gnu::target("avx2"), gnu::always_inline]] inline void test_lanes(const LaneInputs& in, unsigned wanted, bool sphere,
                                                                   TileHits& hits) {
  hits.hit = 0;
  const LaneVector& d = in.direction;
  const LaneVector& m = in.mean;
  const LaneFloat tc = Lanes::mul(dot_lanes(m, d), in.inverse_length2);
  const LaneVector p = {Lanes::sub(Lanes::mul(d.x, tc), m.x), Lanes::sub(Lanes::mul(d.y, tc), m.y),
                        Lanes::sub(Lanes::mul(d.z, tc), m.z)};
  const LaneVector lo = {dot_lanes(in.rows[0], p), dot_lanes(in.rows[1], p), dot_lanes(in.rows[2], p)};
  const LaneVector ld = {dot_lanes(in.rows[0], d), dot_lanes(in.rows[1], d), dot_lanes(in.rows[2], d)};
  const LaneFloat zero = Lanes::all(0.0f), one = Lanes::all(1.0f);
  const LaneFloat length2 = dot_lanes(ld, ld);
  const LaneFloat dt = Lanes::div(Lanes::negative(dot_lanes(lo, ld)), length2);
  const LaneVector peak = {Lanes::add(lo.x, Lanes::mul(dt, ld.x)), Lanes::add(lo.y, Lanes::mul(dt, ld.y)),
                           Lanes::add(lo.z, Lanes::mul(dt, ld.z))};
  const LaneFloat d2 = dot_lanes(peak, peak);
  // The other lanes are left to to_unit_ray(), which transforms them in double.
  const LaneFloat most = Lanes::all(1e30f);
  const LaneFloat in_range = Lanes::both(
      Lanes::both(Lanes::less(Lanes::all(1e-30f), length2), Lanes::less(length2, most)), Lanes::less(d2, most));
  const LaneFloat within = Lanes::both(in_range, Lanes::at_most(d2, one));
  hits.unsure = ~Lanes::mask(in_range) & wanted;
  unsigned candidates = Lanes::mask(within) & wanted;
  if (candidates == 0) return;

  // hit_alpha()
  const LaneFloat exponent = Lanes::mul(Lanes::all(-0.5f), Lanes::mul(in.kappa2, Lanes::both(d2, within)));
  const LaneFloat alpha = Lanes::min(Lanes::mul(in.opacity, Lanes::exp_negative(exponent)), Lanes::all(kAlphaMax));
  Lanes::store(hits.alpha, alpha);
  candidates &= Lanes::mask(Lanes::at_most(Lanes::all(kAlphaMin), alpha));
  if (!sphere) {
    hits.unsure |= candidates;
    return;
  }

  // canonical_hit() of a sphere with entry keys.
  const LaneFloat t_peak = Lanes::add(tc, dt);
  const LaneFloat half = Lanes::sqrt(Lanes::div(Lanes::sub(one, d2), length2));
  const LaneFloat t_enter = Lanes::add(t_peak, Lanes::negative(half));
  candidates &= Lanes::mask(Lanes::less(zero, Lanes::add(t_peak, half)));
  const unsigned ahead = Lanes::mask(Lanes::less(zero, t_enter));
  hits.unsure |= candidates & ~ahead;
  candidates &= ahead;
  LaneFloat enter = Lanes::all(-kUnbounded), exit = Lanes::all(kUnbounded);
  clip_axis(in.low.x, in.high.x, in.inverse.x, enter, exit);
  clip_axis(in.low.y, in.high.y, in.inverse.y, enter, exit);
  clip_axis(in.low.z, in.high.z, in.inverse.z, enter, exit);
  enter = Lanes::mul(Lanes::max(enter, zero), Lanes::all(1.0f - kSlabSlack));
  exit = Lanes::mul(exit, Lanes::all(1.0f + kSlabSlack));
  // The object box is that of the unit sphere widened by 1e-5. If the entry point is inside it by half of that, the ray
  // enters the box before the sphere and leaves it later despite rounding, so clamping to it changes nothing.
  const LaneFloat x = Lanes::size(Lanes::sub(peak.x, Lanes::mul(half, ld.x)));
  const LaneFloat y = Lanes::size(Lanes::sub(peak.y, Lanes::mul(half, ld.y)));
  const LaneFloat z = Lanes::size(Lanes::sub(peak.z, Lanes::mul(half, ld.z)));
  const LaneFloat inner = Lanes::all(1.000005f);
  const unsigned inside_box = Lanes::mask(
      Lanes::both(Lanes::both(Lanes::at_most(x, inner), Lanes::at_most(y, inner)), Lanes::at_most(z, inner)));
  hits.unsure |= candidates & ~inside_box;
  Lanes::store(hits.t, Lanes::min(exit, Lanes::max(enter, t_enter)));
  hits.hit = candidates & inside_box & Lanes::mask(Lanes::at_most(enter, exit));
}

[[gnu::target("avx2"), gnu::always_inline]] inline LaneVector all_lanes(const glm::vec3& v) {
  return {Lanes::all(v.x), Lanes::all(v.y), Lanes::all(v.z)};
}

[[gnu::target("avx2")]] void test_vector_avx2(const TileGaussian& g, const Box& box, const TileRays& tile,
                                              unsigned vector, unsigned wanted, bool sphere, TileHits& hits) {
  const std::size_t at = std::size_t{vector} * kTileLanes;
  LaneInputs in;
  in.direction = {Lanes::load(&tile.direction[0][at]), Lanes::load(&tile.direction[1][at]),
                  Lanes::load(&tile.direction[2][at])};
  in.inverse = {Lanes::load(&tile.inverse[0][at]), Lanes::load(&tile.inverse[1][at]),
                Lanes::load(&tile.inverse[2][at])};
  in.inverse_length2 = Lanes::load(&tile.inverse_length2[at]);
  in.mean = all_lanes(g.mean - tile.origin);
  for (int i = 0; i < 3; ++i) in.rows[i] = all_lanes(g.to_unit[i]);
  in.kappa2 = Lanes::all(g.kappa2);
  in.opacity = Lanes::all(g.opacity);
  in.low = all_lanes(box.lower - tile.origin);
  in.high = all_lanes(box.upper - tile.origin);
  test_lanes(in, wanted, sphere, hits);
}

[[gnu::target("avx2")]] void test_pairs_avx2(const TileStructure& structure, const TileRays& tile,
                                             const TilePair* pairs, unsigned count, bool sphere, TileHits& hits) {
  static_assert(offsetof(TileGaussian, to_unit) == 16 && offsetof(TileGaussian, kappa2) == 52 &&
                offsetof(TileGaussian, opacity) == 56 && sizeof(TileBox) == 32);
  const float *rays[kTileLanes], *gaussians[kTileLanes], *boxes[kTileLanes];
  for (unsigned i = 0; i < kTileLanes; ++i) {
    const TilePair& pair = pairs[std::min(i, count - 1)];
    rays[i] = tile.packed[pair.ray];
    gaussians[i] = &structure.gaussian(pair.gaussian).mean.x;
    boxes[i] = &structure.box(pair.gaussian).box.lower.x;
  }
  LaneFloat ray[8], g[16], box[8];
  for (std::size_t i = 0; i < 8; i += 4) load_columns(rays, i, ray + i);
  for (std::size_t i = 0; i < 16; i += 4) load_columns(gaussians, i, g + i);
  for (std::size_t i = 0; i < 8; i += 4) load_columns(boxes, i, box + i);
  const LaneVector origin = all_lanes(tile.origin);
  LaneInputs in;
  in.direction = {ray[0], ray[1], ray[2]};
  in.inverse_length2 = ray[3];
  in.inverse = {ray[4], ray[5], ray[6]};
  in.mean = {Lanes::sub(g[0], origin.x), Lanes::sub(g[1], origin.y), Lanes::sub(g[2], origin.z)};
  for (int i = 0; i < 3; ++i) in.rows[i] = {g[4 + 3 * i], g[5 + 3 * i], g[6 + 3 * i]};
  in.kappa2 = g[13];
  in.opacity = g[14];
  in.low = {Lanes::sub(box[0], origin.x), Lanes::sub(box[1], origin.y), Lanes::sub(box[2], origin.z)};
  in.high = {Lanes::sub(box[3], origin.x), Lanes::sub(box[4], origin.y), Lanes::sub(box[5], origin.z)};
  test_lanes(in, (1u << count) - 1u, sphere, hits);
}

/// The three channels side by side.
[[gnu::target("avx2")]] void colour_avx2(const float* sh, unsigned coefficients, const TileBasis& basis, unsigned lane,
                                         float* rgb) {
  const __m128 zero = _mm_setzero_ps();
  const float* value = &basis.values[0][lane];
  __m128 sum = zero;
  // A load of four also reads the next coefficient's red, so the last one is loaded differently: it may end the array.
  for (unsigned j = 1; j < coefficients; ++j, sh += 3, value += kTileLanes) {
    sum = _mm_add_ps(sum, _mm_mul_ps(_mm_broadcast_ss(value), _mm_loadu_ps(sh)));
  }
  const __m128 last = _mm_movelh_ps(_mm_loadl_pi(zero, reinterpret_cast<const __m64*>(sh)), _mm_load_ss(sh + 2));
  sum = _mm_add_ps(sum, _mm_mul_ps(_mm_broadcast_ss(value), last));
  _mm_storeu_ps(rgb, _mm_max_ps(zero, _mm_add_ps(sum, _mm_set1_ps(0.5f))));
}

[[gnu::target("avx2")]] void colours_avx2(const float* sh, unsigned coefficients, const TileBasis& basis,
                                          TileHits& hits) {
  __m256 red = _mm256_setzero_ps(), green = red, blue = red;
  for (unsigned j = 0; j < coefficients; ++j, sh += 3) {
    const __m256 value = _mm256_load_ps(basis.values[j]);
    red = _mm256_add_ps(red, _mm256_mul_ps(value, _mm256_broadcast_ss(sh)));
    green = _mm256_add_ps(green, _mm256_mul_ps(value, _mm256_broadcast_ss(sh + 1)));
    blue = _mm256_add_ps(blue, _mm256_mul_ps(value, _mm256_broadcast_ss(sh + 2)));
  }
  const __m256 half = _mm256_set1_ps(0.5f), zero = _mm256_setzero_ps();
  _mm256_store_ps(hits.colour[0], _mm256_max_ps(zero, _mm256_add_ps(red, half)));
  _mm256_store_ps(hits.colour[1], _mm256_max_ps(zero, _mm256_add_ps(green, half)));
  _mm256_store_ps(hits.colour[2], _mm256_max_ps(zero, _mm256_add_ps(blue, half)));
}

}  // namespace

TileTests tile_tests_avx2() {
  return {test_node_avx2, test_outlines_avx2, test_vector_avx2, test_pairs_avx2, colours_avx2, colour_avx2};
}

}  // namespace grtx::frontend

#endif
