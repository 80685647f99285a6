// A round in a monolithic structure, when nobody asks for events: by lists of known nodes (frontend/tracer/ray_walk.h).
// Visits, hits and counters are those of Traversal::drain_stack().
#include "grtx/frontend/tracer/traversal.h"

namespace grtx::frontend {

/// Whether a ray that records nothing can be walked by lists: one level of nodes in the order near first, each visited
/// when its own t asks for it, and no checkpoints to resume from, which name nodes one by one.
bool Traversal::can_walk_lists(const TracedStructure& structure) const {
  return blas_root_ == 0 && structure.world == nullptr && !options_.checkpoint && options_.tracing == Tracing::multi &&
         options_.child_order == ChildOrder::near_first && options_.pop_test == PopTest::on &&
         options_.triangle_test == TriangleTest::canonical;
}

inline void Traversal::take_hit(std::uint32_t link, RayState& state) {
  const KEntry& hit = memory_.hit(link);
  if (policy_.blended_before(hit, state)) return;
  policy_.any_hit(hit, state);
  walk_.set_t_max(state.t_max);
}

inline void Traversal::walk_leaf(const TraceRay& ray, RayState& state) {
  const std::uint32_t link =
      leaf_hits_.link_of_primitive(ray, image_.leaf_index(walk_.address()), object_, memory_, state);
  if (link < WalkMemory::kFirstHit) {
    if (link == WalkMemory::kInside && state.t_last < 0.0f) ++state.counters.inside_skipped;
    return walk_.leaf_done();
  }
  const float t = memory_.hit(link).t;
  walk_.leaf_hit(t, link);
  if (t >= state.t_last && t <= state.t_max) take_hit(link, state);
}

void Traversal::walk_round(const TraceRay& ray, RayState& state) {
  walk_.begin_round(state.t_min_cull, state.t_last, state.t_max);
  TracerCounters& counters = state.counters;
  for (;;) {
    switch (walk_.step()) {
      case RayWalk::Stop::node:
        ++counters.visits_internal;
        visited(walk_.address(), internal_units_);
        walk_.open(ray.slabs);
        // The Gaussians of the next two nodes; of nodes that are no leaves the table says 0.
        object_.prefetch_record(leaf_hits_.gaussian_of(image_.leaf_index(walk_.soon(1))));
        object_.prefetch_record(leaf_hits_.gaussian_of(image_.leaf_index(walk_.soon(2))));
        break;
      case RayWalk::Stop::leaf:
        ++counters.visits_leaf;
        visited(walk_.address(), 1);
        walk_leaf(ray, state);
        break;
      case RayWalk::Stop::hit:
        take_hit(walk_.hit(), state);
        break;
      case RayWalk::Stop::end:
        counters.visits_internal += walk_.repeated_internal();
        counters.visits_leaf += walk_.repeated_leaves();
        counters.skipped_retests += walk_.repeated_internal() + walk_.repeated_leaves();
        return;
    }
  }
}

}  // namespace grtx::frontend
