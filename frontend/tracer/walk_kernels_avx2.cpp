// The walk's inner loops in AVX2: eight known nodes at once, and a node's children to the stack without a branch a
// child.
#include "grtx/frontend/tracer/walk_kernels_avx2.h"

#if defined(__x86_64__)

#include <immintrin.h>

#include <array>

#include "grtx/frontend/tracer/node_intersection.h"

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

/// Lane i is the child that goes to place i of those hit. By 29 bits of `enter` (>= +0) and the slot: children whose
/// entry t differ in the other three bits may come out the wrong way round.
[[gnu::target("avx2"), gnu::always_inline]] inline __m256i farthest_first_avx2(__m256 enter, __m256i hit) {
  // Keys grow towards the ray's origin; children that are not hit go last.
  const __m256i from_zero = _mm256_andnot_si256(_mm256_castps_si256(enter), _mm256_set1_epi32(~7));
  const __m256i key = _mm256_or_si256(_mm256_or_si256(from_zero, _mm256_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0)),
                                      _mm256_xor_si256(hit, _mm256_set1_epi32(-1)));
  // Batcher's bitonic sort: by distances 1; 2, 1; 4, 2, 1. The masks say who keeps the larger one.
  __m256i other = _mm256_shuffle_epi32(key, 0xB1);
  __m256i keys = _mm256_blend_epi32(_mm256_min_epu32(key, other), _mm256_max_epu32(key, other), 0x66);
  other = _mm256_shuffle_epi32(keys, 0x4E);
  keys = _mm256_blend_epi32(_mm256_min_epu32(keys, other), _mm256_max_epu32(keys, other), 0x3C);
  other = _mm256_shuffle_epi32(keys, 0xB1);
  keys = _mm256_blend_epi32(_mm256_min_epu32(keys, other), _mm256_max_epu32(keys, other), 0x5A);
  other = _mm256_permute4x64_epi64(keys, 0x4E);
  keys = _mm256_blend_epi32(_mm256_min_epu32(keys, other), _mm256_max_epu32(keys, other), 0xF0);
  other = _mm256_shuffle_epi32(keys, 0x4E);
  keys = _mm256_blend_epi32(_mm256_min_epu32(keys, other), _mm256_max_epu32(keys, other), 0xCC);
  other = _mm256_shuffle_epi32(keys, 0xB1);
  keys = _mm256_blend_epi32(_mm256_min_epu32(keys, other), _mm256_max_epu32(keys, other), 0xAA);
  return _mm256_xor_si256(keys, _mm256_set1_epi32(7));  // permutations read the lowest three bits
}

/// Pushes the `count` children whose lanes are set in `hit`, and says which of them begin before `bound`.
[[gnu::target("avx2,bmi,popcnt"), gnu::always_inline]] inline void push_avx2(WalkState& walk, __m256 enter, __m256 exit,
                                                                             __m256i what, __m256i hit, unsigned count,
                                                                             float bound) {
  const __m256i from = farthest_first_avx2(enter, hit);
  const __m256 entries = _mm256_permutevar8x32_ps(enter, from);
  WalkStack& stack = walk.stack;
  const std::uint32_t at = stack.size;
  _mm256_storeu_ps(&stack.enter[at], entries);
  _mm256_storeu_ps(&stack.exit[at], _mm256_permutevar8x32_ps(exit, from));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(&stack.what[at]), _mm256_permutevar8x32_epi32(what, from));
  stack.size = at + count;
  walk.pushed_at = at;
  const unsigned pushed = (1u << count) - 1u;
  walk.sticking_out =
      pushed & static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(entries, _mm256_set1_ps(bound), _CMP_LT_OQ)));
  const __m256 next = _mm256_permutevar8x32_ps(entries, _mm256_setr_epi32(1, 2, 3, 4, 5, 6, 7, 7));
  const auto rising = static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(entries, next, _CMP_LT_OQ)));
  if ((rising & pushed >> 1) != 0) sort_pushed(walk);
}

template <typename Form>
[[gnu::target("avx2,bmi,popcnt")]] void open_avx2(WalkState& walk, const NodeImage& image, std::uint32_t address,
                                                  const SlabRay& ray, float bound, float exit_above) {
  static const NodeTest test = node_test_unordered(SimdPath::avx2, Form::kLayout);
  const std::uint8_t* const node = image.node_at(address);
  NodeHits hits;
  test(node, address, ray, {0.0f, walk.t_min}, hits);
  const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  const __m256i hit = _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(static_cast<int>(hits.hit)), bit), bit);

  const __m256i wide = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(kWideBefore[hits.info.wide])));
  const __m256i child =
      _mm256_add_epi32(_mm256_set1_epi32(static_cast<int>(hits.info.child_base)), _mm256_add_epi32(lane, wide));
  const __m256i info =
      _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(child_bytes(Form::kLayout, node))));
  const __m256i internal = _mm256_cmpeq_epi32(_mm256_srli_epi32(info, 2), _mm256_setzero_si256());
  const __m256i what =
      _mm256_or_si256(child, _mm256_andnot_si256(internal, _mm256_set1_epi32(static_cast<int>(WalkList::kLeaf))));
  const __m256 enter = _mm256_load_ps(hits.enter);
  const __m256 exit = _mm256_min_ps(_mm256_load_ps(hits.exit), _mm256_set1_ps(exit_above));

  push_avx2(walk, enter, exit, what, hit, hits.count, bound);
  image.prefetch_children(hits.info.child_base);
}

}  // namespace

WalkKernels walk_kernels_avx2(const InternalLayout& layout) {
  return with_node_form(layout, []<typename Form>(Form) -> WalkKernels { return {scan_avx2, open_avx2<Form>}; });
}

}  // namespace grtx::frontend

#endif
