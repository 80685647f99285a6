#include "grtx/frontend/tracer/node_intersection.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace grtx::frontend {
namespace {

template <unsigned kSlots>
constexpr InternalLayout kLayout = internal_layout(kSlots);
template <unsigned kSlots>
constexpr unsigned kSlotMask = (1u << kSlots) - 1u;

std::uint32_t child_base_of(const std::uint8_t* node, std::uint32_t address) {
  std::int32_t offset = 0;
  std::memcpy(&offset, node + 12, 4);
  return address + static_cast<std::uint32_t>(offset);
}

float axis_origin(const std::uint8_t* node, unsigned axis) {
  float origin = 0.0f;
  std::memcpy(&origin, node + 4 * axis, 4);
  return origin;
}

template <unsigned kSlots>
void test_portable(const std::uint8_t* node, std::uint32_t address, const SlabRay& ray, const NodeQuery& query,
                   NodeHits& hits) {
  ChildInfo info;
  info.child_base = child_base_of(node, address);
  for (unsigned slot = 0; slot < kSlots; ++slot) {
    const unsigned size = node[kLayout<kSlots>.child_info + slot] & 3u;
    info.valid |= (size != 0 ? 1u : 0u) << slot;
    info.wide |= (size >> 1) << slot;
  }
  float near_t[8] = {}, far_t[8] = {};
  for (unsigned axis = 0; axis < 3; ++axis) {
    const float origin = axis_origin(node, axis);
    const float step = kExponentStep[node[18 + axis]];
    const std::uint8_t* lower = node + kLayout<kSlots>.bounds + 2 * axis * kSlots;
    const std::uint8_t* near_bytes = ray.negative[axis] ? lower + kSlots : lower;
    const std::uint8_t* far_bytes = ray.negative[axis] ? lower : lower + kSlots;
    const float ray_origin = ray.origin[static_cast<int>(axis)];
    const float inverse = ray.inverse[static_cast<int>(axis)];
    for (unsigned slot = 0; slot < kSlots; ++slot) {
      const float a = ((origin + static_cast<float>(near_bytes[slot]) * step) - ray_origin) * inverse;
      const float b = ((origin + static_cast<float>(far_bytes[slot]) * step) - ray_origin) * inverse;
      near_t[slot] = axis == 0 || !(near_t[slot] > a) ? a : near_t[slot];
      far_t[slot] = axis == 0 || !(far_t[slot] < b) ? b : far_t[slot];
    }
  }
  unsigned hit = 0;
  for (unsigned slot = 0; slot < kSlots; ++slot) {
    float enter = near_t[slot] + query.t_offset;
    enter = (enter > 0.0f ? enter : 0.0f) * (1.0f - kSlabSlack);
    const float exit = (far_t[slot] + query.t_offset) * (1.0f + kSlabSlack);
    hits.enter[slot] = enter;
    hits.exit[slot] = exit;
    hit |= (enter <= exit && exit >= query.t_min ? 1u : 0u) << slot;
  }
  hits.hit = hit & info.valid;
  hits.count = static_cast<unsigned>(__builtin_popcount(hits.hit));
  hits.info = info;
  for (unsigned slot = 0; slot < kSlots; ++slot) {
    if ((hits.hit >> slot & 1) == 0) continue;
    std::int32_t rank = 0;
    for (unsigned other = 0; other < kSlots; ++other) {
      if (other == slot || (hits.hit >> other & 1) == 0) continue;
      const float a = hits.enter[other], b = hits.enter[slot];
      rank += a < b || (a == b && other < slot) ? 1 : 0;
    }
    hits.rank[slot] = rank;
  }
}

#if defined(__x86_64__)

/// The bounds of one array as floats, in lanes 0 .. slots-1. Reads nothing beyond the node: the last array of a
/// six-slot node ends at byte 64.
template <unsigned kSlots>
[[gnu::target("avx2,bmi,popcnt"), gnu::always_inline]] inline __m256 bounds_avx2(const std::uint8_t* bytes,
                                                                                 bool last_axis) {
  std::uint64_t packed = 0;
  if (kSlots == 6 && last_axis) {
    std::memcpy(&packed, bytes - 2, 8);
    packed >>= 16;
  } else {
    std::memcpy(&packed, bytes, 8);
  }
  return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(packed))));
}

template <unsigned kSlots>
[[gnu::target("avx2,bmi,popcnt"), gnu::always_inline]] inline ChildInfo child_info_avx2(const std::uint8_t* node,
                                                                                        std::uint32_t address) {
  const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(node + kLayout<kSlots>.child_info));
  const __m128i unused = _mm_cmpeq_epi8(_mm_and_si128(bytes, _mm_set1_epi8(3)), _mm_setzero_si128());
  ChildInfo info;
  info.valid = ~static_cast<unsigned>(_mm_movemask_epi8(unused)) & kSlotMask<kSlots>;
  info.wide = static_cast<unsigned>(_mm_movemask_epi8(_mm_slli_epi16(bytes, 6))) & kSlotMask<kSlots>;
  info.child_base = child_base_of(node, address);
  return info;
}

/// From near and far slab parameters to the answer, with ranks or without.
template <bool kRanked>
[[gnu::target("avx2,bmi,popcnt"), gnu::always_inline]] inline void finish_avx2(__m256 near_t, __m256 far_t,
                                                                               const ChildInfo& info,
                                                                               const NodeQuery& query, NodeHits& hits) {
  const __m256 offset = _mm256_set1_ps(query.t_offset);
  const __m256 enter = _mm256_mul_ps(_mm256_max_ps(_mm256_add_ps(near_t, offset), _mm256_setzero_ps()),
                                     _mm256_set1_ps(1.0f - kSlabSlack));
  const __m256 exit = _mm256_mul_ps(_mm256_add_ps(far_t, offset), _mm256_set1_ps(1.0f + kSlabSlack));
  _mm256_store_ps(hits.enter, enter);
  _mm256_store_ps(hits.exit, exit);
  const __m256 hit = _mm256_and_ps(_mm256_cmp_ps(enter, exit, _CMP_LE_OQ),
                                   _mm256_cmp_ps(exit, _mm256_set1_ps(query.t_min), _CMP_GE_OQ));
  hits.hit = static_cast<unsigned>(_mm256_movemask_ps(hit)) & info.valid;
  hits.count = static_cast<unsigned>(__builtin_popcount(hits.hit));
  hits.info = info;
  if constexpr (!kRanked) return;
  if (hits.count < 2) {
    hits.rank[__builtin_ctz(hits.hit | 0x80u)] = 0;
    return;
  }
  // entry t are >= +0, so their bits order as they do; other lanes go last. A lane counts the lanes before it:
  // key[j] < key[i], or equal and j < i, which is key[j] < key[i] + 1.
  const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  const __m256i in = _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(static_cast<int>(hits.hit)), bit), bit);
  const __m256i key = _mm256_blendv_epi8(_mm256_set1_epi32(0x7FFFFFF0), _mm256_castps_si256(enter), in);
  alignas(32) std::int32_t keys[8];
  _mm256_store_si256(reinterpret_cast<__m256i*>(keys), key);
  const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  __m256i rank = _mm256_setzero_si256();
  for (unsigned rest = hits.hit; rest != 0; rest &= rest - 1) {
    const int j = __builtin_ctz(rest);
    const __m256i after = _mm256_cmpgt_epi32(lane, _mm256_set1_epi32(j));  // -1 where i > j
    rank = _mm256_sub_epi32(rank, _mm256_cmpgt_epi32(_mm256_sub_epi32(key, after), _mm256_set1_epi32(keys[j])));
  }
  _mm256_store_si256(reinterpret_cast<__m256i*>(hits.rank), rank);
}

template <unsigned kSlots, bool kRanked = true>
[[gnu::target("avx2,bmi,popcnt")]] void test_avx2(const std::uint8_t* node, std::uint32_t address, const SlabRay& ray,
                                                  const NodeQuery& query, NodeHits& hits) {
  const ChildInfo info = child_info_avx2<kSlots>(node, address);
  __m256 near_t = _mm256_setzero_ps(), far_t = _mm256_setzero_ps();
  for (unsigned axis = 0; axis < 3; ++axis) {
    const __m256 origin = _mm256_broadcast_ss(reinterpret_cast<const float*>(node) + axis);
    const __m256 step = _mm256_broadcast_ss(&kExponentStep[node[18 + axis]]);
    const __m256 ray_origin = _mm256_broadcast_ss(&ray.origin[static_cast<int>(axis)]);
    const __m256 inverse = _mm256_broadcast_ss(&ray.inverse[static_cast<int>(axis)]);
    const std::uint8_t* lower = node + kLayout<kSlots>.bounds + 2 * axis * kSlots;
    const unsigned flip = ray.negative[axis] ? kSlots : 0;
    const __m256 near_q = bounds_avx2<kSlots>(lower + flip, axis == 2);
    const __m256 far_q = bounds_avx2<kSlots>(lower + (kSlots - flip), axis == 2);
    const __m256 near_bound = _mm256_add_ps(origin, _mm256_mul_ps(near_q, step));
    const __m256 far_bound = _mm256_add_ps(origin, _mm256_mul_ps(far_q, step));
    const __m256 a = _mm256_mul_ps(_mm256_sub_ps(near_bound, ray_origin), inverse);
    const __m256 b = _mm256_mul_ps(_mm256_sub_ps(far_bound, ray_origin), inverse);
    near_t = axis == 0 ? a : _mm256_max_ps(near_t, a);
    far_t = axis == 0 ? b : _mm256_min_ps(far_t, b);
  }
  finish_avx2<kRanked>(near_t, far_t, info, query, hits);
}

// Near and far bounds of an axis share one register: lanes 0..7 near, 8..15 far.
template <unsigned kSlots>
[[gnu::target("avx512f,avx512vl,avx2,bmi,popcnt")]] void test_avx512(const std::uint8_t* node, std::uint32_t address,
                                                                     const SlabRay& ray, const NodeQuery& query,
                                                                     NodeHits& hits) {
  const ChildInfo info = child_info_avx2<kSlots>(node, address);
  __m512 near_far[3];
  for (unsigned axis = 0; axis < 3; ++axis) {
    const __m512 origin = _mm512_set1_ps(axis_origin(node, axis));
    const __m512 step = _mm512_set1_ps(kExponentStep[node[18 + axis]]);
    const __m512 ray_origin = _mm512_set1_ps(ray.origin[static_cast<int>(axis)]);
    const __m512 inverse = _mm512_set1_ps(ray.inverse[static_cast<int>(axis)]);
    const std::uint8_t* lower = node + kLayout<kSlots>.bounds + 2 * axis * kSlots;
    const unsigned flip = ray.negative[axis] ? kSlots : 0;
    std::uint64_t halves[2];
    const bool at_end = kSlots == 6 && axis == 2;  // reads nothing beyond the node
    std::memcpy(&halves[0], lower + flip - (at_end ? 2 : 0), 8);
    std::memcpy(&halves[1], lower + (kSlots - flip) - (at_end ? 2 : 0), 8);
    if (at_end) {
      halves[0] >>= 16;
      halves[1] >>= 16;
    }
    const __m128i packed = _mm_set_epi64x(static_cast<long long>(halves[1]), static_cast<long long>(halves[0]));
    const __m512 q = _mm512_maskz_cvtepi32_ps(0xFFFF, _mm512_maskz_cvtepu8_epi32(0xFFFF, packed));
    const __m512 bound = _mm512_add_ps(origin, _mm512_mul_ps(q, step));
    near_far[axis] = _mm512_mul_ps(_mm512_sub_ps(bound, ray_origin), inverse);
  }
  // max for the near half, min for the far one; each keeps its second operand when one is no number, as on the other
  // paths.
  const __m512 most = _mm512_maskz_max_ps(0xFFFF, _mm512_maskz_max_ps(0xFFFF, near_far[0], near_far[1]), near_far[2]);
  const __m512 least = _mm512_maskz_min_ps(0xFFFF, _mm512_maskz_min_ps(0xFFFF, near_far[0], near_far[1]), near_far[2]);
  alignas(64) float both[2][16];
  _mm512_store_ps(both[0], most);
  _mm512_store_ps(both[1], least);
  const __m256 near_t = _mm256_load_ps(both[0]);
  const __m256 far_t = _mm256_load_ps(both[1] + 8);
  finish_avx2<true>(near_t, far_t, info, query, hits);
}

#endif

template <unsigned kSlots>
NodeTest node_test_of(SimdPath path) {
#if defined(__x86_64__)
  if (path == SimdPath::avx512) return test_avx512<kSlots>;
  if (path == SimdPath::avx2) return test_avx2<kSlots>;
#endif
  static_cast<void>(path);
  return test_portable<kSlots>;
}

}  // namespace

NodeTest node_test_unordered(SimdPath path, unsigned slots) {
#if defined(__x86_64__)
  if (path == SimdPath::avx2) return slots == 6 ? test_avx2<6, false> : test_avx2<8, false>;
#endif
  return node_test(path, slots);
}

NodeTest node_test(SimdPath path, unsigned slots) { return slots == 6 ? node_test_of<6>(path) : node_test_of<8>(path); }

}  // namespace grtx::frontend
