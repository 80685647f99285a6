#include <bit>
#include <algorithm>

#include "frontend/ray_walk.h"
#include "frontend/walk_kernels_avx512.h"

namespace grtx::frontend {
namespace {

bool scan_portable(WalkState& walk) {
  WalkList& known = walk.known;
  WalkList& next = walk.next;
  for (; walk.position < known.size; ++walk.position) {
    const std::uint32_t i = walk.position;
    if (!(known.exit[i] >= walk.t_min)) continue;
    const float state = known.state[i];
    if (known.enter[i] <= walk.t_max) {
      if (state < 0.0f || (state >= walk.t_last && state <= walk.t_max)) return true;
      ++((known.what[i] & WalkList::kLeaf) != 0 ? walk.repeated_leaves : walk.repeated_internal);
    }
    next.append(known.enter[i], known.exit[i], state, known.what[i]);
  }
  return false;
}

template <SimdPath kPath, unsigned kSlots>
void open_node(WalkState& walk, const NodeImage& image, std::uint32_t address, const SlabRay& ray, float bound,
               float exit) {
  static const NodeTest test = node_test(kPath, kSlots);
  const std::uint8_t* const node = image.data() + std::uint64_t{address} * traces::kNodeUnit;
  NodeHits hits;
  test(node, address, ray, {0.0f, walk.t_min}, hits);
  WalkStack& stack = walk.stack;
  walk.pushed_at = stack.size;
  walk.sticking_out = 0;
  const std::uint32_t last = stack.size + hits.count - 1;
  for (unsigned rest = hits.hit; rest != 0; rest &= rest - 1) {
    const auto slot = static_cast<unsigned>(std::countr_zero(rest));
    const std::uint32_t child = hits.info.child_base + child_offset(hits.info, slot);
    const bool leaf = node[internal_layout(kSlots).child_info + slot] >> 2 != 0;
    if (!leaf) __builtin_prefetch(image.data() + std::uint64_t{child} * traces::kNodeUnit);
    const auto before = static_cast<std::uint32_t>(hits.rank[slot]);
    const std::uint32_t place = last - before;
    stack.enter[place] = hits.enter[slot];
    stack.exit[place] = std::min(hits.exit[slot], exit);
    stack.what[place] = child | (leaf ? WalkList::kLeaf : 0u);
    if (hits.enter[slot] < bound) walk.sticking_out |= std::uint64_t{1} << (place - walk.pushed_at);
  }
  stack.size += hits.count;
}

}  // namespace

WalkKernels walk_kernels(SimdPath path, unsigned slots) {
  const bool six = slots == 6;
  if (path == SimdPath::avx512) {
    const WalkKernels others{scan_portable, six ? open_node<SimdPath::avx512, 6> : open_node<SimdPath::avx512, 8>};
#if defined(__x86_64__)
    return walk_kernels_avx512(slots, others).value_or(others);
#else
    return others;
#endif
  }
  if (path == SimdPath::avx2) return {scan_portable, six ? open_node<SimdPath::avx2, 6> : open_node<SimdPath::avx2, 8>};
  return {scan_portable, six ? open_node<SimdPath::portable, 6> : open_node<SimdPath::portable, 8>};
}

}  // namespace grtx::frontend
