// RayTracer's rounds in monolithic structures, when nobody asks for events: by lists of known nodes
// (frontend/tracer/ray_walk.h). Visits, hits and counters are those of drain_stack(). Included by
// frontend/tracer/ray_tracer.h.
#pragma once

#include "grtx/frontend/tracer/ray_tracer.h"

namespace grtx::frontend {

/// Whether a ray that records nothing can be walked by lists: one level of nodes in the order near first, and no
/// checkpoints to resume from, which name nodes one by one.
inline bool RayTracer::can_walk_lists() const {
  return blas_root_ == 0 && world_ == nullptr && remember_ && !options_.checkpoint &&
         options_.tracing == Tracing::multi && options_.child_order == ChildOrder::near_first &&
         options_.triangle_test == TriangleTest::canonical;
}

inline void RayTracer::walk_round(const TraceRay& ray) {
  walk_.begin_round(t_min_cull_, t_last_, t_max_);
  const unsigned internal_units = layout_.slots == 6 ? 1 : 2;
  for (;;) {
    switch (walk_.step()) {
      case RayWalk::Stop::node:
        ++counters_.visits_internal;
        visited(walk_.address(), internal_units);
        walk_.open(ray.slabs);
        // The Gaussians of the next two nodes; of nodes that are no leaves the table says 0.
        gaussians_.prefetch_record(gaussian_of(image_.leaf_index(walk_.soon(1))));
        gaussians_.prefetch_record(gaussian_of(image_.leaf_index(walk_.soon(2))));
        break;
      case RayWalk::Stop::leaf:
        ++counters_.visits_leaf;
        visited(walk_.address(), 1);
        walk_leaf(ray);
        break;
      case RayWalk::Stop::hit:
        take_hit(walk_.hit());
        break;
      case RayWalk::Stop::end:
        counters_.visits_internal += walk_.repeated_internal();
        counters_.visits_leaf += walk_.repeated_leaves();
        counters_.skipped_retests += walk_.repeated_internal() + walk_.repeated_leaves();
        return;
    }
  }
}

inline void RayTracer::walk_leaf(const TraceRay& ray) {
  const std::uint32_t link = link_of_primitive(ray, image_.leaf_index(walk_.address()));
  if (link < WalkMemory::kFirstHit) {
    if (link == WalkMemory::kInside && t_last_ < 0.0f) ++counters_.inside_skipped;
    return walk_.leaf_done();
  }
  const float t = memory_.hit(link).t;
  walk_.leaf_hit(t, link);
  if (t >= t_last_ && t <= t_max_) take_hit(link);
}

inline void RayTracer::take_hit(std::uint32_t link) {
  const KEntry& hit = memory_.hit(link);
  if (blended_before(hit)) return;
  any_hit(hit);
  walk_.set_t_max(t_max_);
}

}  // namespace grtx::frontend
