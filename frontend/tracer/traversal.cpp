// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tracer/traversal.h"

#include <limits>

#include "grtx/frontend/tracer/encoding_recorder.h"
#include "grtx/frontend/tracer/ray_recorder.h"
#include "grtx/frontend/tracer/ray_watch.h"
#include "grtx/traces/orders/child_order.h"

namespace grtx::frontend {
namespace {

Box box_of_children(const NodeImage& image, std::uint32_t root) {
  const DecodedInternal node = image.decode_internal(root * image.sizes().unit());
  Box box;
  for (unsigned i = 0; i < node.child_count; ++i) box.extend(node.boxes[i]);
  return box;
}

}  // namespace

Traversal::Traversal(const TracedStructure& structure, const TracerOptions& options)
    : image_(structure.image),
      layout_(structure.image.layout()),
      internal_units_(structure.image.sizes().units(NodeKind::internal)),
      root_(structure.root),
      blas_root_(structure.blas_root),
      root_box_(box_of_children(structure.image, structure.root)),
      options_(options),
      test_children_(node_test(options.simd, layout_)),
      policy_(options),
      walk_(options.ahead),
      object_(structure.gaussians, structure.world),
      leaf_hits_(structure, options),
      records_(structure, options) {}

void Traversal::begin_ray(const TraceRay& ray) {
  memory_.clear();
  add_root(root_);
  object_.begin_ray();
  leaf_hits_.begin_ray(ray);
  if (tracker_ != nullptr) tracker_->begin_ray();
}

bool Traversal::misses_scene(const TraceRay& ray) const { return conservative_interval(ray.slabs, root_box_).empty(); }

template <typename Recorder>
void Traversal::miss_scene(RayState& state, Recorder& recorder) {
  ++state.counters.skipped_scene_misses;
  ++state.counters.rounds;
  ++state.counters.visits_internal;
  visited(root_, internal_units_);
  recorder.begin_round(false);
  recorder.pop();
  recorder.internal(recorder.open(root_), root_, 0, 0);
  recorder.end_round({});
}

template <typename Recorder>
void Traversal::round(const TraceRay& ray, RayState& state, Recorder& recorder) {
  traces::with_child_order(options_.child_order, [&]<typename Order>(Order) {
    stack_.clear();
    if (state.replay) return resume<Order>(ray, state, recorder);
    push_root(0, 0.0f, 0, 0);
    if (options_.ahead > 1) return drain_ahead<Order>(ray, state, recorder);
    drain_stack<Order>(ray, state, recorder);
  });
}

template <typename Order, typename Recorder>
void Traversal::resume(const TraceRay& ray, RayState& state, Recorder& recorder) {
  if (state.checkpoints.has_bins()) {
    while (state.checkpoints.must_read(state.t_max)) {
      resume_at<Order>(ray, state.checkpoints.read(), state, recorder);
    }
    return;
  }
  state.checkpoints.begin_reading();
  while (state.checkpoints.more()) resume_at<Order>(ray, state.checkpoints.read(), state, recorder);
}

template <typename Order, typename Recorder>
void Traversal::resume_at(const TraceRay& ray, const StackEntry& entry, RayState& state, Recorder& recorder) {
  ++state.counters.checkpoints_read;
  if (entry.t > state.t_max) {
    const bool kept = state.checkpoint(entry);
    recorder.event(traces::EventKind::replay_forward, units_of(entry.node), 0, kept ? 1 : 0);
    return;
  }
  recorder.event(traces::EventKind::replay_take, units_of(entry.node), 0, 0);
  // The ray must be transformed again before a node inside an instance can be tested.
  if (entry.object != 0) {
    ++state.counters.visits_instance;
    visited_leaf(entry.object, memory_[entry.object].packed);
    recorder.event(traces::EventKind::visit_instance, units_of(entry.object), 1, 0);
  }
  if (entry.in_blas()) {
    ++state.counters.visits_instance;
    visited_leaf(entry.instance, memory_[entry.instance].packed);
    recorder.event(traces::EventKind::visit_instance, units_of(entry.instance), 1, 0);
    enter_instance(local_ray(ray, entry), entry.instance, state);
  }
  stack_.push({entry.t, entry.node, memory_[entry.node].packed, entry.instance, entry.object});
  drain_stack<Order>(ray, state, recorder);
}

template <typename Order, typename Recorder>
void Traversal::drain_stack(const TraceRay& ray, RayState& state, Recorder& recorder) {
  while (!stack_.empty()) {
    const StackEntry entry = stack_.pop();
    recorder.pop();
    if (entry.t > end_of(entry, state) && pop_test_) {
      if (state.is_hidden(entry.t)) ++state.counters.opacity->nodes;
      const bool kept = state.checkpoint(entry);
      recorder.event(traces::EventKind::cull, units_of(entry.node), 0, kept ? 1 : 0);
      continue;
    }
    visit<Order>(ray, entry, state, recorder);
  }
}

template <typename Order, typename Recorder>
inline void Traversal::visit(const TraceRay& ray, const StackEntry& entry, RayState& state, Recorder& recorder) {
  switch (ReachedNode::kind_of(entry.packed)) {
    case NodeKind::internal:
      visit_internal<Order>(local_ray(ray, entry), entry, state, recorder);
      break;
    case NodeKind::instance:
    case NodeKind::wide_instance:
      visit_instance<Order>(ray, entry, state, recorder);
      break;
    default:
      if (ReachedNode::link_of(entry.packed) == WalkMemory::kMissed) {  // most leaves of later rounds
        ++state.counters.visits_leaf;
        ++state.counters.skipped_retests;
        visited_leaf(entry.node, entry.packed);
        recorder.event(traces::EventKind::visit_leaf, units_of(entry.node),
                       static_cast<unsigned>(traces::LeafOutcome::miss), 0);
        break;
      }
      visit_leaf<Order>(local_ray(ray, entry), entry, state, recorder);
      break;
  }
}

template <typename Order, typename Recorder>
void Traversal::drain_ahead(const TraceRay& ray, RayState& state, Recorder& recorder) {
  if constexpr (Recorder::kDepthFirst) {
    tree_.begin();
    walk_ahead<Order>(ray, state, tree_);
    tree_.replay(recorder);
  } else {
    walk_ahead<Order>(ray, state, recorder);
  }
}

// traces/rules/ahead_stack.h says which node is done next, and where its children come.
template <typename Order, typename Recorder>
void Traversal::walk_ahead(const TraceRay& ray, RayState& state, Recorder& recorder) {
  walk_.begin({stack_.pop(), {}});
  while (true) {
    walk_.start([&](const AheadEntry& next) { return starts(next, state, recorder); });
    if (walk_.empty()) return;
    const AheadEntry done = walk_.take();
    recorder.at(done.place);
    visit<Order>(ray, done.entry, state, recorder);
    const std::uint32_t parent = recorder.last();
    for (auto child = static_cast<std::uint32_t>(stack_.size()); child-- > 0;) {
      walk_.push({stack_.pop(), {parent, child}});
    }
  }
}

/// Whether a node that has its turn is visited; beyond t_max it is culled.
template <typename Recorder>
bool Traversal::starts(const AheadEntry& next, RayState& state, Recorder& recorder) {
  if (!pop_test_ || next.entry.t <= state.t_max) return true;
  if (state.is_hidden(next.entry.t)) ++state.counters.opacity->nodes;
  recorder.at(next.place);
  recorder.event(traces::EventKind::cull, units_of(next.entry.node), 0, 0);
  return false;
}

template <typename Order, typename Recorder>
void Traversal::visit_internal(const TraceRay& ray, const StackEntry& entry, RayState& state, Recorder& recorder) {
  ++state.counters.visits_internal;
  visited(units_of(entry.node), internal_units_);
  std::uint32_t list = memory_[entry.node].link();
  if (list == 0) {
    list = test_boxes<Order>(ray, entry.node, entry.in_blas(), state.t_min_cull);
  } else {
    ++state.counters.skipped_retests;
  }
  // The list's last child is pushed first, so that the first ends on top of the stack; a child that is followed at once
  // goes on top of it.
  const ReachedNode* const children = &memory_[list];
  const std::uint32_t count = children->node;
  StackEntry* top = stack_.top();
  const std::uint32_t units = Recorder::kEnabled ? units_of(entry.node) : 0;
  typename Recorder::Children opened = recorder.open(units);
  unsigned pushed = 0, beyond = 0;
  const float t_max = end_of(entry, state);
  [[maybe_unused]] const std::uint32_t followed =
      Order::kFollows ? followed_child<Order>(children, state.t_min_cull, t_max) : 0;
  for (std::uint32_t i = count; i > 0; --i) {
    const ReachedNode& child = children[i];
    // Written without branches, which would be unpredictable.
    const unsigned alive = child.exit >= state.t_min_cull ? 1u : 0u;
    const unsigned within = child.enter <= t_max ? alive : 0u;
    const unsigned now = Order::kFollows && i == followed ? 0u : within;
    *top = {child.enter, list + i, child.packed, entry.instance, entry.object};
    top += now;
    if (Recorder::kEnabled) pushed |= within << child.slot();
    opened.put(child.slot(), now);
    beyond |= (alive ^ within) << child.slot();
  }
  if (Order::kFollows && followed != 0) {
    const ReachedNode& child = children[followed];
    *top++ = {child.enter, list + followed, child.packed, entry.instance, entry.object};
    opened.put(child.slot(), 1);
  }
  stack_.set_top(top);
  for (std::uint32_t i = 1; state.ends_early() && i <= count; ++i) {
    if (children[i].exit >= state.t_min_cull && state.is_hidden(children[i].enter)) ++state.counters.opacity->nodes;
  }
  unsigned checkpoints = 0;
  if (beyond != 0 && state.checkpoints.enabled()) checkpoints = checkpoint_children(entry, list, beyond, state);
  recorder.internal(opened, units, pushed, checkpoints);
}

/// Place in the list of the child that is visited before all others pushed with it; 0: none.
template <typename Order>
inline unsigned Traversal::followed_child(const ReachedNode* children, float t_min, float t_max) const {
  const std::uint32_t count = children->node;
  unsigned pushed = 0, internal = 0;
  for (std::uint32_t i = 1; i <= count; ++i) {
    const ReachedNode& child = children[i];
    if (child.exit >= t_min && child.enter <= t_max) pushed |= 1u << child.slot();
    if (ReachedNode::kind_of(child.packed) == NodeKind::internal) internal |= 1u << child.slot();
  }
  const unsigned followed = Order::followed(pushed, internal);
  for (std::uint32_t i = 1; i <= count; ++i) {
    if (followed == 1u << children[i].slot()) return i;
  }
  return 0;
}

/// Tests the boxes of a node's children; returns the list of those hit: its head, then the children in visiting order.
template <typename Order>
inline std::uint32_t Traversal::test_boxes(const TraceRay& ray, std::uint32_t node, bool blas, float t_min_cull) {
  const std::uint32_t units = units_of(node);
  const std::uint8_t* data = image_.node_at(units);
  NodeHits hits;
  if (blas) {
    const EnteredInstance& instance = memory_.instance(instance_);
    test_children_(data, units, instance.slabs, {instance.unit.t_peak, t_min_cull}, hits);
  } else {
    test_children_(data, units, ray.slabs, {0.0f, t_min_cull}, hits);
  }
  if (!blas) image_.prefetch_children(hits.info.child_base);
  const std::uint64_t children = child_bytes(layout_, data);
  const std::uint32_t list = memory_.reserve(hits.count + 1);
  ReachedNode* const head = &memory_[list];
  head->node = hits.count;
  for (unsigned rest = hits.hit; rest != 0; rest &= rest - 1) {
    const auto slot = static_cast<unsigned>(__builtin_ctz(rest));
    const std::uint32_t child = hits.info.child_base + child_offset(hits.info, slot);
    const auto kind = static_cast<NodeKind>(children >> (8 * slot + 2) & 0x3F);
    head[1 + Order::place(slot, hits.hit, static_cast<unsigned>(hits.rank[slot]))] =
        ReachedNode(hits.enter[slot], hits.exit[slot], child, kind, slot);
  }
  memory_[node].set_link(list);
  return list;
}

/// Checkpoints the children in `mask`, in slot order; returns the mask of those kept.
inline unsigned Traversal::checkpoint_children(const StackEntry& parent, std::uint32_t list, unsigned mask,
                                               RayState& state) {
  std::uint32_t at[traces::kMaxWidth] = {};
  const std::uint32_t count = memory_[list].node;
  for (std::uint32_t i = 1; i <= count; ++i) at[memory_[list + i].slot()] = list + i;
  unsigned kept = 0;
  for (unsigned rest = mask; rest != 0; rest &= rest - 1) {
    const auto slot = static_cast<unsigned>(__builtin_ctz(rest));
    const ReachedNode& child = memory_[at[slot]];
    if (state.checkpoint({child.enter, at[slot], child.packed, parent.instance, parent.object})) kept |= 1u << slot;
  }
  return kept;
}

template <typename Order, typename Recorder>
void Traversal::visit_instance(const TraceRay& ray, const StackEntry& entry, RayState& state, Recorder& recorder) {
  ++state.counters.visits_instance;
  visited_leaf(entry.node, entry.packed);
  recorder.event(traces::EventKind::visit_instance, units_of(entry.node), 0, 0);
  if (object_.one_of_several() && entry.object == 0) {
    enter_object(ray, entry.node);
    return push_root(memory_[entry.node].link(), entry.t, 0, entry.node);
  }
  enter_instance(local_ray(ray, entry), entry.node, state);
  if (walk_blas_) return push_root(memory_.instance(instance_).root, entry.t, entry.node, entry.object);
  offer<Order>(leaf_hits_.link_of_instance(local_ray(ray, entry), memory_.instance(instance_), object_, memory_), entry,
               state, recorder);
}

inline void Traversal::enter_instance(const TraceRay& ray, std::uint32_t leaf, RayState& state) {
  instance_ = memory_[leaf].link();
  if (instance_ != 0) {
    ++state.counters.skipped_retests;
    return;
  }
  instance_ = memory_.add_instance();
  memory_[leaf].set_link(instance_);
  EnteredInstance& instance = memory_.instance(instance_);
  leaf_hits_.enter(instance, ray, image_.leaf_index(units_of(leaf)), object_);
  instance.root = add_root(blas_root_);
}

void Traversal::enter_object(const TraceRay& ray, std::uint32_t leaf) {
  const PlacedObject& placed = object_.enter(ray, leaf, image_.leaf_index(units_of(leaf)));
  if (memory_[leaf].link() != 0) return;
  const std::uint32_t root = add_root(static_cast<std::uint32_t>(placed.object->root / image_.sizes().unit()));
  memory_[leaf].set_link(root);
}

std::uint32_t Traversal::add_root(std::uint32_t units) {
  return memory_.add({0.0f, std::numeric_limits<float>::infinity(), units, NodeKind::internal, 0});
}

template <typename Order, typename Recorder>
void Traversal::visit_leaf(const TraceRay& ray, const StackEntry& entry, RayState& state, Recorder& recorder) {
  ++state.counters.visits_leaf;
  visited_leaf(entry.node, entry.packed);
  std::uint32_t link = memory_[entry.node].link();
  if (link == 0) {
    EnteredInstance* const instance = entry.in_blas() ? &memory_.instance(instance_) : nullptr;
    link = leaf_hits_.link_of_leaf(ray, units_of(entry.node), instance, object_, memory_, state);
    memory_[entry.node].set_link(link);
  } else {
    ++state.counters.skipped_retests;
  }
  offer<Order>(link, entry, state, recorder);
}

/// Handles a leaf's test result (`link`): the any-hit shader, a checkpoint, or nothing.
template <typename Order, typename Recorder>
void Traversal::offer(std::uint32_t link, const StackEntry& entry, RayState& state, Recorder& recorder) {
  using traces::LeafOutcome;
  const auto outcome = [&](LeafOutcome o, unsigned checkpoints = 0, unsigned shifts = 0) {
    recorder.event(traces::EventKind::visit_leaf, units_of(entry.node), static_cast<unsigned>(o), checkpoints, shifts);
  };
  if (link == WalkMemory::kMissed) return outcome(LeafOutcome::miss);
  if (link == WalkMemory::kInside) {
    if (state.t_last < 0.0f) ++state.counters.inside_skipped;
    return outcome(LeafOutcome::miss);
  }
  KEntry hit = memory_.hit(link);
  if (const auto before = policy_.blended_before(hit, state)) return outcome(*before);
  if (hit.t > end_of(entry, state)) {
    if (state.is_hidden(hit.t)) ++state.counters.opacity->hits;
    const bool kept = state.checkpoint({hit.t, entry.node, entry.packed, entry.instance, entry.object});
    return outcome(LeafOutcome::beyond, kept ? 1 : 0);
  }
  if (bounds_opacity_) hit.opacity = traces::opacity_steps(records_.alpha(hit, records_.of(hit.id)));
  const traces::RoundHits<KEntry>::Taken taken = HitPolicy::take(hit, state);
  outcome(taken.outcome, taken.hidden, taken.shifts);
}

template void Traversal::miss_scene(RayState&, NullRecorder&);
template void Traversal::miss_scene(RayState&, GroupRecorder&);
template void Traversal::miss_scene(RayState&, EncodingRecorder&);
template void Traversal::miss_scene(RayState&, RayWatch&);
template void Traversal::round(const TraceRay&, RayState&, NullRecorder&);
template void Traversal::round(const TraceRay&, RayState&, GroupRecorder&);
template void Traversal::round(const TraceRay&, RayState&, EncodingRecorder&);
template void Traversal::round(const TraceRay&, RayState&, RayWatch&);

}  // namespace grtx::frontend
