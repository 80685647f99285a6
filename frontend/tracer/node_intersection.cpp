// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tracer/node_intersection.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace grtx::frontend {
namespace {

template <typename Form>
constexpr unsigned kSlotMask = (1u << Form::kSlots) - 1u;

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

// Bound array `number` of a node as bytes: lowerX, upperX, lowerY, ... Reads nothing beyond the node: the last array of
// a six-slot node ends at byte 64, as does that of a packed one.
template <typename Form>
inline std::uint64_t codes_of(const std::uint8_t* node, unsigned number) {
  std::uint64_t codes = 0;
  if constexpr (Form::kPacked) {
    const std::uint8_t* const packed = node + Form::kLayout.bounds + number * kPackedBits;
    std::memcpy(&codes, packed - 1, sizeof codes);
    return unpacked_codes(codes >> 8);
  }
  const std::uint8_t* const bytes = node + Form::kLayout.bounds + number * Form::kSlots;
  if (Form::kSlots == 6 && number >= 4) {
    std::memcpy(&codes, bytes - 2, sizeof codes);
    return codes >> 16;
  }
  std::memcpy(&codes, bytes, sizeof codes);
  return codes;
}

template <typename Form>
ChildInfo child_info_portable(const std::uint8_t* node, std::uint32_t address) {
  ChildInfo info;
  info.child_base = child_base_of(node, address);
  if constexpr (Form::kPacked) {
    info.valid = node[kPackedUsed];
    return info;
  }
  for (unsigned slot = 0; slot < Form::kSlots; ++slot) {
    const unsigned size = node[Form::kLayout.child_info + slot] & 3u;
    info.valid |= (size != 0 ? 1u : 0u) << slot;
    info.wide |= (size >> 1) << slot;
  }
  return info;
}

template <typename Form>
void test_portable(const std::uint8_t* node, std::uint32_t address, const SlabRay& ray, const NodeQuery& query,
                   NodeHits& hits) {
  constexpr unsigned kSlots = Form::kSlots;
  const ChildInfo info = child_info_portable<Form>(node, address);
  float near_t[8] = {}, far_t[8] = {};
  for (unsigned axis = 0; axis < 3; ++axis) {
    const float origin = axis_origin(node, axis);
    const float ray_origin = ray.origin[static_cast<int>(axis)];
    const float step = kExponentStep[node[18 + axis]];
    const unsigned flip = ray.negative[axis] ? 1 : 0;
    const std::uint64_t near_codes = codes_of<Form>(node, 2 * axis + flip);
    const std::uint64_t far_codes = codes_of<Form>(node, 2 * axis + 1 - flip);
    const float inverse = ray.inverse[static_cast<int>(axis)];
    for (unsigned slot = 0; slot < kSlots; ++slot) {
      const auto near_code = static_cast<float>(near_codes >> (8 * slot) & 0xFF);
      const auto far_code = static_cast<float>(far_codes >> (8 * slot) & 0xFF);
      const float a = ((origin + near_code * step) - ray_origin) * inverse;
      const float b = ((origin + far_code * step) - ray_origin) * inverse;
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

/// Bytes as floats, in lanes 0 .. slots-1.
[[gnu::target("avx2,bmi,popcnt"), gnu::always_inline]] inline __m256 bounds_avx2(std::uint64_t codes) {
  return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(codes))));
}

template <typename Form>
[[gnu::target("avx2,bmi,popcnt"), gnu::always_inline]] inline ChildInfo child_info_avx2(const std::uint8_t* node,
                                                                                        std::uint32_t address) {
  if constexpr (Form::kPacked) return child_info_portable<Form>(node, address);
  const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(node + Form::kLayout.child_info));
  const __m128i unused = _mm_cmpeq_epi8(_mm_and_si128(bytes, _mm_set1_epi8(3)), _mm_setzero_si128());
  ChildInfo info;
  info.valid = ~static_cast<unsigned>(_mm_movemask_epi8(unused)) & kSlotMask<Form>;
  info.wide = static_cast<unsigned>(_mm_movemask_epi8(_mm_slli_epi16(bytes, 6))) & kSlotMask<Form>;
  info.child_base = child_base_of(node, address);
  return info;
}

/// Computes the hits from near and far slab parameters, with or without ranks.
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

template <typename Form, bool kRanked = true>
[[gnu::target("avx2,bmi,popcnt")]] void test_avx2(const std::uint8_t* node, std::uint32_t address, const SlabRay& ray,
                                                  const NodeQuery& query, NodeHits& hits) {
  const ChildInfo info = child_info_avx2<Form>(node, address);
  __m256 near_t = _mm256_setzero_ps(), far_t = _mm256_setzero_ps();
  for (unsigned axis = 0; axis < 3; ++axis) {
    const __m256 origin = _mm256_broadcast_ss(reinterpret_cast<const float*>(node) + axis);
    const __m256 step = _mm256_broadcast_ss(&kExponentStep[node[18 + axis]]);
    const __m256 ray_origin = _mm256_broadcast_ss(&ray.origin.x + axis);
    const __m256 inverse = _mm256_broadcast_ss(&ray.inverse.x + axis);
    const unsigned flip = ray.negative[axis] ? 1 : 0;
    const __m256 near_q = bounds_avx2(codes_of<Form>(node, 2 * axis + flip));
    const __m256 far_q = bounds_avx2(codes_of<Form>(node, 2 * axis + 1 - flip));
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
template <typename Form>
[[gnu::target("avx512f,avx512vl,avx2,bmi,popcnt")]] void test_avx512(const std::uint8_t* node, std::uint32_t address,
                                                                     const SlabRay& ray, const NodeQuery& query,
                                                                     NodeHits& hits) {
  const ChildInfo info = child_info_avx2<Form>(node, address);
  __m512 near_far[3];
  for (unsigned axis = 0; axis < 3; ++axis) {
    const __m512 origin = _mm512_set1_ps(axis_origin(node, axis));
    const __m512 step = _mm512_set1_ps(kExponentStep[node[18 + axis]]);
    const __m512 ray_origin = _mm512_set1_ps(ray.origin[static_cast<int>(axis)]);
    const __m512 inverse = _mm512_set1_ps(ray.inverse[static_cast<int>(axis)]);
    const unsigned flip = ray.negative[axis] ? 1 : 0;
    const std::uint64_t near_codes = codes_of<Form>(node, 2 * axis + flip);
    const std::uint64_t far_codes = codes_of<Form>(node, 2 * axis + 1 - flip);
    const __m128i packed = _mm_set_epi64x(static_cast<long long>(far_codes), static_cast<long long>(near_codes));
    const __m512 q = _mm512_maskz_cvtepi32_ps(0xFFFF, _mm512_maskz_cvtepu8_epi32(0xFFFF, packed));
    const __m512 bound = _mm512_add_ps(origin, _mm512_mul_ps(q, step));
    near_far[axis] = _mm512_mul_ps(_mm512_sub_ps(bound, ray_origin), inverse);
  }
  // max for the near half, min for the far one; each returns its second operand if one is NaN, as on the other paths.
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

}  // namespace

NodeTest node_test_unordered(SimdPath path, const InternalLayout& layout) {
#if defined(__x86_64__)
  if (path == SimdPath::avx2) {
    return with_node_form(layout, []<typename Form>(Form) -> NodeTest { return test_avx2<Form, false>; });
  }
#endif
  return node_test(path, layout);
}

NodeTest node_test(SimdPath path, const InternalLayout& layout) {
  return with_node_form(layout, [&]<typename Form>(Form) -> NodeTest {
#if defined(__x86_64__)
    if (path == SimdPath::avx512) return test_avx512<Form>;
    if (path == SimdPath::avx2) return test_avx2<Form>;
#endif
    static_cast<void>(path);
    return test_portable<Form>;
  });
}

}  // namespace grtx::frontend
