// SPDX-License-Identifier: Apache-2.0
// Walks the node image for one round of a ray: visits nodes, resumes from checkpoints, and offers hits to the hit
// policy. docs/model/tracer.md states the order; every visit that the hardware model replays is decided here.
#pragma once

#include <cstdint>

#include "grtx/frontend/accel/node_image.h"
#include "grtx/frontend/gaussian/canonical_hit.h"
#include "grtx/frontend/tracer/current_object.h"
#include "grtx/frontend/tracer/hit_policy.h"
#include "grtx/frontend/tracer/hit_records.h"
#include "grtx/frontend/tracer/leaf_hits.h"
#include "grtx/frontend/tracer/node_intersection.h"
#include "grtx/frontend/tracer/ray_state.h"
#include "grtx/frontend/tracer/traced_structure.h"
#include "grtx/frontend/tracer/tracer_options.h"
#include "grtx/frontend/tracer/traversal_stack.h"
#include "grtx/frontend/tracer/tree_recorder.h"
#include "grtx/frontend/tracer/visit_tracker.h"
#include "grtx/frontend/tracer/walk_memory.h"
#include "grtx/traces/rules/ahead_stack.h"

namespace grtx::frontend {

/// One per tracer. Recorder: frontend/tracer/ray_recorder.h.
class Traversal {
 public:
  Traversal(const TracedStructure& structure, const TracerOptions& options);

  void track_visits(VisitTracker* tracker) { tracker_ = tracker; }
  const TraversalStack& stack() const { return stack_; }
  void begin_ray(const TraceRay& ray);
  bool misses_scene(const TraceRay& ray) const;
  /// t at which the ray enters the scene's box: it enters no other box before.
  float scene_enter(const TraceRay& ray) const { return conservative_interval(ray.slabs, root_box_).enter; }
  /// Traces a ray that misses the scene: it visits the root, hits no child, and its only round ends without a hit.
  template <typename Recorder>
  void miss_scene(RayState& state, Recorder& recorder);
  /// Traverses from the root, or from the checkpoints that the last round wrote.
  template <typename Recorder>
  void round(const TraceRay& ray, RayState& state, Recorder& recorder);

 private:
  // Order: traces/orders/child_order.h. Functions that do not need it are templates on it, too: each then has one
  // caller and is inlined.
  template <typename Order, typename Recorder>
  void resume(const TraceRay& ray, RayState& state, Recorder& recorder);
  template <typename Order, typename Recorder>
  void resume_at(const TraceRay& ray, const StackEntry& entry, RayState& state, Recorder& recorder);
  template <typename Order, typename Recorder>
  void drain_stack(const TraceRay& ray, RayState& state, Recorder& recorder);
  /// The same with up to TracerOptions::ahead nodes under way at once.
  template <typename Order, typename Recorder>
  void drain_ahead(const TraceRay& ray, RayState& state, Recorder& recorder);
  template <typename Order, typename Recorder>
  void walk_ahead(const TraceRay& ray, RayState& state, Recorder& recorder);
  template <typename Order, typename Recorder>
  void visit(const TraceRay& ray, const StackEntry& entry, RayState& state, Recorder& recorder);
  template <typename Order, typename Recorder>
  void visit_internal(const TraceRay& ray, const StackEntry& entry, RayState& state, Recorder& recorder);
  template <typename Order, typename Recorder>
  void visit_instance(const TraceRay& ray, const StackEntry& entry, RayState& state, Recorder& recorder);
  template <typename Order, typename Recorder>
  void visit_leaf(const TraceRay& ray, const StackEntry& entry, RayState& state, Recorder& recorder);
  template <typename Order, typename Recorder>
  void offer(std::uint32_t link, const StackEntry& entry, RayState& state, Recorder& recorder);
  template <typename Order>
  std::uint32_t test_boxes(const TraceRay& ray, std::uint32_t node, bool blas, float t_min_cull);
  template <typename Order>
  unsigned followed_child(const ReachedNode* children, float t_min, float t_max) const;
  unsigned checkpoint_children(const StackEntry& parent, std::uint32_t list, unsigned mask, RayState& state);
  void enter_instance(const TraceRay& ray, std::uint32_t leaf, RayState& state);
  void enter_object(const TraceRay& ray, std::uint32_t leaf);

  /// ahead > 1: an entry of the stack.
  struct AheadEntry {
    StackEntry entry;
    PushedPlace place;
  };
  template <typename Recorder>
  bool starts(const AheadEntry& next, RayState& state, Recorder& recorder);

  /// The t beyond which the nodes at the entry are not visited in this round.
  float end_of(const StackEntry& entry, const RayState& state) const {
    return finish_instances_ && entry.in_blas() ? state.t_limit : state.t_max;
  }
  /// The ray in the space of the entry's node.
  const TraceRay& local_ray(const TraceRay& ray, const StackEntry& entry) {
    if (entry.object == 0) return ray;
    if (!object_.is(entry.object)) enter_object(ray, entry.object);
    return object_.ray();
  }
  void push_root(std::uint32_t node, float t, std::uint32_t instance, std::uint32_t object) {
    stack_.push({t, node, memory_[node].packed, instance, object});
  }
  std::uint32_t add_root(std::uint32_t units);
  std::uint32_t units_of(std::uint32_t node) { return memory_[node].node; }
  void visited(std::uint32_t units, unsigned size_units) {
    if (tracker_ != nullptr) tracker_->visit(units, size_units);
  }
  /// node: link into memory_.
  void visited_leaf(std::uint32_t node, std::uint32_t packed) {
    if (tracker_ != nullptr) tracker_->visit(units_of(node), image_.sizes().units(ReachedNode::kind_of(packed)));
  }

  const NodeImage& image_;
  const InternalLayout layout_;
  const unsigned internal_units_;  ///< of an internal node
  const std::uint32_t root_;       ///< units
  const std::uint32_t blas_root_;  ///< units
  const Box root_box_;             ///< contains the decoded boxes of the root's children
  const TracerOptions options_;
  const bool pop_test_ = options_.pop_test == PopTest::on;
  const bool bounds_opacity_ = options_.opacity_bound == OpacityBound::on;
  const bool finish_instances_ = options_.checkpoint && options_.below_instance == BelowInstance::finish;
  /// With stored triangles the BLAS must be walked: only their vertices decide which of them are hit.
  const bool walk_blas_ = options_.walk_blas || options_.triangle_test == TriangleTest::world;
  const NodeTest test_children_;
  const HitPolicy policy_;

  TraversalStack stack_;
  traces::AheadStack<AheadEntry> walk_;  ///< ahead > 1: the stack
  TreeRecorder tree_;
  WalkMemory memory_;
  std::uint32_t instance_ = 0;  ///< the one being walked, link into memory_
  CurrentObject object_;
  LeafHits leaf_hits_;
  const HitRecords records_;  ///< for opacities
  VisitTracker* tracker_ = nullptr;
};

}  // namespace grtx::frontend
