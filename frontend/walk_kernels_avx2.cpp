// The walk's inner loops in AVX2: eight known nodes at once, and a node's children to the stack without a branch a
// child.
#include "frontend/walk_kernels_x86.h"

#if defined(__x86_64__)

#include <immintrin.h>

#include <array>

#include "frontend/node_test.h"

namespace grtx::frontend {
namespace {

constexpr unsigned kAvx2Lanes = 8;

/// By mask: its lanes, in order, a byte each.
constexpr std::array<std::uint64_t, 256> kCompressed = [] {
  std::array<std::uint64_t, 256> table{};
  for (unsigned mask = 0; mask < 256; ++mask) {
    unsigned count = 0;
    for (std::uint64_t lane = 0; lane < 8; ++lane) {
      if ((mask >> lane & 1u) != 0) table[mask] |= lane << (8 * count++);
    }
  }
  return table;
}();

[[gnu::target("avx2,bmi,popcnt"), gnu::always_inline]] inline unsigned lane_mask(__m256 lanes) {
  return static_cast<unsigned>(_mm256_movemask_ps(lanes));
}

[[gnu::target("avx2,bmi,popcnt")]] bool scan_avx2(WalkState& walk) {
  const WalkList& known = walk.known;
  WalkList& next = walk.next;
  const __m256 t_min = _mm256_set1_ps(walk.t_min), t_max = _mm256_set1_ps(walk.t_max);
  const __m256 t_last = _mm256_set1_ps(walk.t_last);
  std::uint32_t to = next.size, position = walk.position;
  unsigned visits = 0, leaf_visits = 0;
  bool found = false;
  while (position < known.size && !found) {
    const unsigned count = known.size - position < kAvx2Lanes ? known.size - position : kAvx2Lanes;
    const __m256 enter = _mm256_loadu_ps(&known.enter[position]);
    const __m256 exit = _mm256_loadu_ps(&known.exit[position]);
    const __m256 state = _mm256_loadu_ps(&known.state[position]);
    const __m256 what = _mm256_loadu_ps(reinterpret_cast<const float*>(&known.what[position]));
    const unsigned alive = lane_mask(_mm256_cmp_ps(exit, t_min, _CMP_GE_OQ)) & ((1u << count) - 1u);
    const unsigned visited = alive & lane_mask(_mm256_cmp_ps(enter, t_max, _CMP_LE_OQ));
    const __m256 asks = _mm256_cmp_ps(state, _mm256_setzero_ps(), _CMP_LT_OQ);
    const __m256 hits =
        _mm256_and_ps(_mm256_cmp_ps(state, t_last, _CMP_GE_OQ), _mm256_cmp_ps(state, t_max, _CMP_LE_OQ));
    const unsigned stops = visited & lane_mask(_mm256_or_ps(asks, hits));
    found = stops != 0;
    const unsigned taken = found ? static_cast<unsigned>(__builtin_ctz(stops)) : count;
    const unsigned before = (1u << taken) - 1u;
    const unsigned kept = alive & before, counted = visited & before;
    visits += static_cast<unsigned>(__builtin_popcount(counted));
    leaf_visits += static_cast<unsigned>(__builtin_popcount(counted & lane_mask(what)));
    const __m256i from = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(kCompressed[kept])));
    _mm256_storeu_ps(&next.enter[to], _mm256_permutevar8x32_ps(enter, from));
    _mm256_storeu_ps(&next.exit[to], _mm256_permutevar8x32_ps(exit, from));
    _mm256_storeu_ps(&next.state[to], _mm256_permutevar8x32_ps(state, from));
    _mm256_storeu_ps(reinterpret_cast<float*>(&next.what[to]), _mm256_permutevar8x32_ps(what, from));
    to += static_cast<unsigned>(__builtin_popcount(kept));
    position += taken;
  }
  next.size = to;
  walk.position = position;
  walk.repeated_leaves += leaf_visits;
  walk.repeated_internal += visits - leaf_visits;
  return found;
}

template <unsigned kSlots>
[[gnu::target("avx2,bmi,popcnt")]] void open_avx2(WalkState& walk, const NodeImage& image, std::uint32_t address,
                                                  const SlabRay& ray, float bound, float exit_above) {
  static const NodeTest test = node_test(SimdPath::avx2, kSlots);
  const std::uint8_t* const node = image.data() + std::uint64_t{address} * traces::kNodeUnit;
  NodeHits hits;
  test(node, address, ray, {0.0f, walk.t_min}, hits);
  const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  const __m256i hit = _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(static_cast<int>(hits.hit)), bit), bit);

  // The nearest goes last. Which lane goes to place p: three bits each in one number.
  const __m256i rank = _mm256_load_si256(reinterpret_cast<const __m256i*>(hits.rank));
  const __m256i place = _mm256_sub_epi32(_mm256_set1_epi32(static_cast<int>(hits.count) - 1), rank);
  const __m256i fields =
      _mm256_and_si256(hit, _mm256_sllv_epi32(lane, _mm256_add_epi32(place, _mm256_add_epi32(place, place))));
  __m128i lanes = _mm_or_si128(_mm256_castsi256_si128(fields), _mm256_extracti128_si256(fields, 1));
  lanes = _mm_or_si128(lanes, _mm_shuffle_epi32(lanes, 0x4E));
  lanes = _mm_or_si128(lanes, _mm_shuffle_epi32(lanes, 0xB1));
  const __m256i from = _mm256_srlv_epi32(_mm256_broadcastd_epi32(lanes), _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21));

  const __m256i wide = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(kWideBefore[hits.info.wide])));
  const __m256i child =
      _mm256_add_epi32(_mm256_set1_epi32(static_cast<int>(hits.info.child_base)), _mm256_add_epi32(lane, wide));
  const __m256i info = _mm256_cvtepu8_epi32(
      _mm_loadl_epi64(reinterpret_cast<const __m128i*>(node + internal_layout(kSlots).child_info)));
  const __m256i internal = _mm256_cmpeq_epi32(_mm256_srli_epi32(info, 2), _mm256_setzero_si256());
  const __m256i what =
      _mm256_or_si256(child, _mm256_andnot_si256(internal, _mm256_set1_epi32(static_cast<int>(WalkList::kLeaf))));
  const __m256 enter = _mm256_load_ps(hits.enter);
  const __m256 exit = _mm256_min_ps(_mm256_load_ps(hits.exit), _mm256_set1_ps(exit_above));

  WalkStack& stack = walk.stack;
  const std::uint32_t at = stack.size;
  _mm256_storeu_ps(&stack.enter[at], _mm256_permutevar8x32_ps(enter, from));
  _mm256_storeu_ps(&stack.exit[at], _mm256_permutevar8x32_ps(exit, from));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(&stack.what[at]), _mm256_permutevar8x32_epi32(what, from));
  stack.size = at + hits.count;
  // All children: the rays that follow meet those that this one has missed.
  __builtin_prefetch(image.leaf_indices() + hits.info.child_base);
  __builtin_prefetch(image.leaf_indices() + hits.info.child_base + 16);
  for (unsigned i = 0; i < kSlots; ++i) {
    __builtin_prefetch(image.data() + std::uint64_t{hits.info.child_base + i} * traces::kNodeUnit);
  }

  walk.pushed_at = at;
  walk.sticking_out = 0;
  unsigned out = lane_mask(_mm256_cmp_ps(enter, _mm256_set1_ps(bound), _CMP_LT_OQ)) & hits.hit;
  for (; out != 0; out &= out - 1) {
    walk.sticking_out |= 1u << (hits.count - 1 - static_cast<unsigned>(hits.rank[__builtin_ctz(out)]));
  }
}

}  // namespace

WalkKernels walk_kernels_avx2(unsigned slots) { return {scan_avx2, slots == 6 ? open_avx2<6> : open_avx2<8>}; }

}  // namespace grtx::frontend

#endif
