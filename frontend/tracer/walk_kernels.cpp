#include "grtx/frontend/tracer/walk_kernels.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "grtx/frontend/tracer/node_intersection.h"
#include "grtx/frontend/tracer/walk_kernels_avx2.h"

namespace grtx::frontend {
namespace {

bool scan_portable(WalkState& walk) {
  const WalkList& known = walk.known;
  for (; walk.position < known.size; ++walk.position) {
    const std::uint32_t i = walk.position;
    if (!(known.exit[i] >= walk.t_min)) continue;
    const float state = known.state[i];
    if (known.enter[i] <= walk.t_max) {
      if (state < 0.0f || (state >= walk.t_last && state <= walk.t_max)) return true;
      ++((known.what[i] & WalkList::kLeaf) != 0 ? walk.repeated_leaves : walk.repeated_internal);
    }
    walk.next.append(known.enter[i], known.exit[i], state, known.what[i]);
  }
  return false;
}

template <typename Form>
void open_portable(WalkState& walk, const NodeImage& image, std::uint32_t address, const SlabRay& ray, float bound,
                   float exit) {
  static const NodeTest test = node_test(SimdPath::portable, Form::kLayout);
  const std::uint8_t* const node = image.node_at(address);
  NodeHits hits;
  test(node, address, ray, {0.0f, walk.t_min}, hits);
  const std::uint64_t children = child_bytes(Form::kLayout, node);
  WalkStack& stack = walk.stack;
  walk.pushed_at = stack.size;
  walk.sticking_out = 0;
  for (unsigned rest = hits.hit; rest != 0; rest &= rest - 1) {
    const auto slot = static_cast<unsigned>(std::countr_zero(rest));
    const std::uint32_t child = hits.info.child_base + child_offset(hits.info, slot);
    const bool leaf = (children >> (8 * slot) & 0xFC) != 0;
    const std::uint32_t place = hits.count - 1 - static_cast<std::uint32_t>(hits.rank[slot]);
    stack.enter[stack.size + place] = hits.enter[slot];
    stack.exit[stack.size + place] = std::min(hits.exit[slot], exit);
    stack.what[stack.size + place] = child | (leaf ? WalkList::kLeaf : 0u);
    if (hits.enter[slot] < bound) walk.sticking_out |= 1u << place;
  }
  stack.size += hits.count;
  image.prefetch_children(hits.info.child_base);
}

}  // namespace

// Children of equal entry t stand in the right order already; insertion keeps it.
void sort_pushed(WalkState& walk) {
  WalkStack& stack = walk.stack;
  for (std::uint32_t i = walk.pushed_at + 1; i < stack.size; ++i) {
    for (std::uint32_t at = i; at > walk.pushed_at && stack.enter[at - 1] < stack.enter[at]; --at) {
      std::swap(stack.enter[at - 1], stack.enter[at]);
      std::swap(stack.exit[at - 1], stack.exit[at]);
      std::swap(stack.what[at - 1], stack.what[at]);
      const std::uint32_t lower = at - 1 - walk.pushed_at;
      const std::uint32_t pair = walk.sticking_out >> lower & 3u;
      if (pair == 1u || pair == 2u) walk.sticking_out ^= 3u << lower;
    }
  }
}

WalkKernels walk_kernels(SimdPath path, const InternalLayout& layout) {
#if defined(__x86_64__)
  if (path != SimdPath::portable) return walk_kernels_avx2(layout);  // AVX-512 was 1 to 3 % faster
#endif
  static_cast<void>(path);
  return with_node_form(layout, []<typename Form>(Form) -> WalkKernels {
    return {scan_portable, open_portable<Form>};
  });
}

}  // namespace grtx::frontend
