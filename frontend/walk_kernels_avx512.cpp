// The walk's inner loops in AVX-512: sixteen known nodes at once, and a node's near and far bounds in one register.
#include "frontend/walk_kernels_x86.h"

#if defined(__x86_64__)

#include <immintrin.h>

#include <cstring>

#include "frontend/node_test.h"

// gcc 12 takes the undefined vectors in its own headers for uninitialised ones.
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"

#define GRTX_AVX512 gnu::target("avx512f,avx512vl,avx512dq,avx512bw,bmi,popcnt")
#define GRTX_AVX512_BYTES gnu::target("avx512f,avx512vl,avx512dq,avx512bw,avx512vbmi,bmi,popcnt")

namespace grtx::frontend {
namespace {

constexpr unsigned kAvx512Lanes = 16;

[[GRTX_AVX512]] bool scan_avx512(WalkState& walk) {
  const WalkList& known = walk.known;
  WalkList& next = walk.next;
  const __m512 t_min = _mm512_set1_ps(walk.t_min), t_max = _mm512_set1_ps(walk.t_max);
  const __m512 t_last = _mm512_set1_ps(walk.t_last);
  std::uint32_t to = next.size, position = walk.position;
  unsigned visits = 0, leaf_visits = 0;
  bool found = false;
  while (position < known.size && !found) {
    const unsigned count = known.size - position < kAvx512Lanes ? known.size - position : kAvx512Lanes;
    const auto lanes = static_cast<__mmask16>((1u << count) - 1u);
    const __m512 enter = _mm512_loadu_ps(&known.enter[position]);
    const __m512 exit = _mm512_loadu_ps(&known.exit[position]);
    const __m512 state = _mm512_loadu_ps(&known.state[position]);
    const __m512i what = _mm512_loadu_si512(&known.what[position]);
    const __mmask16 alive = _mm512_mask_cmp_ps_mask(lanes, exit, t_min, _CMP_GE_OQ);
    const __mmask16 visited = _mm512_mask_cmp_ps_mask(alive, enter, t_max, _CMP_LE_OQ);
    const __mmask16 asks = _mm512_mask_cmp_ps_mask(visited, state, _mm512_setzero_ps(), _CMP_LT_OQ);
    const __mmask16 hits =
        _mm512_mask_cmp_ps_mask(_mm512_mask_cmp_ps_mask(visited, state, t_last, _CMP_GE_OQ), state, t_max, _CMP_LE_OQ);
    const unsigned stops = static_cast<unsigned>(asks) | static_cast<unsigned>(hits);
    found = stops != 0;
    const unsigned taken = found ? static_cast<unsigned>(__builtin_ctz(stops)) : count;
    const unsigned before = (1u << taken) - 1u;
    const auto kept = static_cast<__mmask16>(alive & before);
    const unsigned counted = visited & before;
    visits += static_cast<unsigned>(__builtin_popcount(counted));
    leaf_visits += static_cast<unsigned>(__builtin_popcount(counted & _mm512_movepi32_mask(what)));
    _mm512_storeu_ps(&next.enter[to], _mm512_maskz_compress_ps(kept, enter));
    _mm512_storeu_ps(&next.exit[to], _mm512_maskz_compress_ps(kept, exit));
    _mm512_storeu_ps(&next.state[to], _mm512_maskz_compress_ps(kept, state));
    _mm512_storeu_si512(&next.what[to], _mm512_maskz_compress_epi32(kept, what));
    to += static_cast<unsigned>(__builtin_popcount(kept));
    position += taken;
  }
  next.size = to;
  walk.position = position;
  walk.repeated_leaves += leaf_visits;
  walk.repeated_internal += visits - leaf_visits;
  return found;
}

/// Where the bytes of a node of six slots go: the byte of child i to the lowest byte of lane i; its near bound's to
/// lane i and its far bound's to lane 8 + i, by axis, and whether the ray goes against it.
struct ByteOrder {
  alignas(64) std::uint8_t bounds[3][2][64] = {};
  alignas(64) std::uint8_t info[64] = {};
  constexpr ByteOrder() {
    constexpr InternalLayout layout = internal_layout(6);
    for (unsigned slot = 0; slot < 6; ++slot) {
      info[4 * slot] = static_cast<std::uint8_t>(layout.child_info + slot);
      for (unsigned axis = 0; axis < 3; ++axis) {
        const unsigned lower = layout.bounds + 12 * axis + slot, upper = lower + 6;
        for (unsigned against = 0; against < 2; ++against) {
          bounds[axis][against][4 * slot] = static_cast<std::uint8_t>(against != 0 ? upper : lower);
          bounds[axis][against][4 * (8 + slot)] = static_cast<std::uint8_t>(against != 0 ? lower : upper);
        }
      }
    }
  }
};
constexpr ByteOrder kByteOrder;
constexpr __mmask64 kBoundLanes = 0x0011'1111'0011'1111u, kInfoLanes = 0x11'1111u;

/// Rotation r of eight lanes twice: by 2r + 1 in the lower half, by 2r + 2 in the upper; and 1 where the lane that
/// comes to i is one before i.
struct Rotations {
  alignas(64) std::int32_t from[4][16] = {};
  alignas(64) std::int32_t earlier[4][16] = {};
  constexpr Rotations() {
    for (unsigned r = 0; r < 4; ++r) {
      for (unsigned i = 0; i < 16; ++i) {
        const unsigned lane = i % 8, source = (lane + 2 * r + 1 + i / 8) % 8;
        from[r][i] = static_cast<std::int32_t>(source);
        earlier[r][i] = source < lane ? 1 : 0;
      }
    }
  }
};
constexpr Rotations kRotations;

/// Slab parameters of all bounds of an axis.
[[GRTX_AVX512_BYTES, gnu::always_inline]] inline __m512 slab(__m512i node, const std::uint8_t* bytes, unsigned axis,
                                                             const SlabRay& ray) {
  const auto component = static_cast<int>(axis);
  const __m512i order = _mm512_load_si512(kByteOrder.bounds[axis][ray.negative[axis] ? 1 : 0]);
  const __m512 codes = _mm512_cvtepi32_ps(_mm512_maskz_permutexvar_epi8(kBoundLanes, order, node));
  float origin = 0.0f;
  std::memcpy(&origin, bytes + 4 * axis, 4);
  const __m512 bound =
      _mm512_add_ps(_mm512_set1_ps(origin), _mm512_mul_ps(codes, _mm512_set1_ps(kExponentStep[bytes[18 + axis]])));
  return _mm512_mul_ps(_mm512_sub_ps(bound, _mm512_set1_ps(ray.origin[component])),
                       _mm512_set1_ps(ray.inverse[component]));
}

/// Nodes of six slots. The arithmetic is that of node_test.cpp.
[[GRTX_AVX512_BYTES]] void open_avx512(WalkState& walk, const NodeImage& image, std::uint32_t address,
                                       const SlabRay& ray, float bound, float exit_above) {
  const std::uint8_t* const bytes = image.data() + std::uint64_t{address} * traces::kNodeUnit;
  const __m512i node = _mm512_loadu_si512(bytes);
  const __m512 x = slab(node, bytes, 0, ray), y = slab(node, bytes, 1, ray), z = slab(node, bytes, 2, ray);
  // max for the near half, min for the far one; each keeps its second operand when one is no number.
  const __m512 most = _mm512_max_ps(_mm512_max_ps(x, y), z);
  const __m512 least = _mm512_min_ps(_mm512_min_ps(x, y), z);
  const __m256 zero = _mm256_setzero_ps();
  const __m256 enter =
      _mm256_mul_ps(_mm256_max_ps(_mm512_castps512_ps256(most), zero), _mm256_set1_ps(1.0f - kSlabSlack));
  const __m256 exit =
      _mm256_mul_ps(_mm256_add_ps(_mm512_extractf32x8_ps(least, 1), zero), _mm256_set1_ps(1.0f + kSlabSlack));
  const __m256i info =
      _mm512_castsi512_si256(_mm512_maskz_permutexvar_epi8(kInfoLanes, _mm512_load_si512(kByteOrder.info), node));
  const __mmask8 valid = _mm256_test_epi32_mask(info, _mm256_set1_epi32(3));
  const __mmask8 hit = _mm256_mask_cmp_ps_mask(_mm256_mask_cmp_ps_mask(valid, enter, exit, _CMP_LE_OQ), exit,
                                               _mm256_set1_ps(walk.t_min), _CMP_GE_OQ);
  const auto count = static_cast<std::uint32_t>(__builtin_popcount(hit));

  std::int32_t offset = 0;
  std::memcpy(&offset, bytes + 12, 4);
  const std::uint32_t child_base = address + static_cast<std::uint32_t>(offset);
  // Every child takes one unit: nodes of two are instances, and internal ones of eight slots.
  const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  const __m256i child = _mm256_add_epi32(lane, _mm256_set1_epi32(static_cast<std::int32_t>(child_base)));
  const __mmask8 leaf = _mm256_test_epi32_mask(info, _mm256_set1_epi32(0x3C));
  const __m256i what =
      _mm256_mask_or_epi32(child, leaf, child, _mm256_set1_epi32(static_cast<std::int32_t>(WalkList::kLeaf)));

  // How many hit children come before each, in the order (enter, slot). Entry t are >= +0, so their bits order as they
  // do; the other lanes go last.
  const __m256i key = _mm256_mask_blend_epi32(hit, _mm256_set1_epi32(0x7FFFFFF0), _mm256_castps_si256(enter));
  const __m512i keys = _mm512_broadcast_i32x8(key);
  __m512i before = _mm512_setzero_si512();
  for (unsigned r = 0; r < 4; ++r) {
    const __m512i other = _mm512_permutexvar_epi32(_mm512_load_si512(kRotations.from[r]), keys);
    const __mmask16 first =
        _mm512_cmplt_epi32_mask(other, _mm512_add_epi32(keys, _mm512_load_si512(kRotations.earlier[r])));
    before = _mm512_mask_add_epi32(before, first, before, _mm512_set1_epi32(1));
  }
  const __m256i rank = _mm256_add_epi32(_mm512_castsi512_si256(before), _mm512_extracti32x8_epi32(before, 1));
  // The nearest goes last. Which lane goes to place p: three bits each in one number.
  const __m256i place = _mm256_sub_epi32(_mm256_set1_epi32(static_cast<std::int32_t>(count) - 1), rank);
  const __m256i fields = _mm256_maskz_sllv_epi32(hit, lane, _mm256_add_epi32(place, _mm256_add_epi32(place, place)));
  __m128i lanes = _mm_or_si128(_mm256_castsi256_si128(fields), _mm256_extracti128_si256(fields, 1));
  lanes = _mm_or_si128(lanes, _mm_shuffle_epi32(lanes, 0x4E));
  lanes = _mm_or_si128(lanes, _mm_shuffle_epi32(lanes, 0xB1));
  const __m256i from = _mm256_srlv_epi32(_mm256_broadcastd_epi32(lanes), _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21));

  WalkStack& stack = walk.stack;
  const std::uint32_t at = stack.size;
  _mm256_storeu_ps(&stack.enter[at], _mm256_permutevar8x32_ps(enter, from));
  _mm256_storeu_ps(&stack.exit[at], _mm256_permutevar8x32_ps(_mm256_min_ps(exit, _mm256_set1_ps(exit_above)), from));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(&stack.what[at]), _mm256_permutevar8x32_epi32(what, from));
  stack.size = at + count;

  // All children: the rays that follow meet those that this one has missed.
  __builtin_prefetch(image.leaf_indices() + child_base);
  __builtin_prefetch(image.leaf_indices() + child_base + 16);
  for (unsigned i = 0; i < 6; ++i) {
    __builtin_prefetch(image.data() + std::uint64_t{child_base + i} * traces::kNodeUnit);
  }

  walk.pushed_at = at;
  walk.sticking_out = 0;
  unsigned out = _mm256_mask_cmp_ps_mask(hit, enter, _mm256_set1_ps(bound), _CMP_LT_OQ);
  if (out != 0) {
    alignas(32) std::uint32_t places[8];
    _mm256_store_si256(reinterpret_cast<__m256i*>(places), place);
    for (; out != 0; out &= out - 1) walk.sticking_out |= 1u << places[__builtin_ctz(out)];
  }
}

}  // namespace

WalkKernels walk_kernels_avx512(unsigned slots) {
  __builtin_cpu_init();
  const bool permutes_bytes = __builtin_cpu_supports("avx512vbmi") != 0;
  return {scan_avx512, slots == 6 && permutes_bytes ? open_avx512 : walk_kernels_avx2(slots).open};
}

}  // namespace grtx::frontend

#endif
