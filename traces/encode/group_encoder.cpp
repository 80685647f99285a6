// SPDX-License-Identifier: Apache-2.0
#include "grtx/traces/encode/group_encoder.h"

#include <bit>
#include <span>
#include <vector>

#include "grtx/traces/checkpoint_bins.h"
#include "grtx/traces/codec/pop_order.h"
#include "grtx/traces/encode/pop_encoder.h"
#include "grtx/traces/orders/checkpoint_order.h"
#include "grtx/traces/source_assignment.h"

namespace grtx::traces {

struct GroupEncoder::Impl {
  void begin(const Header& header, std::uint32_t index, RayKind kind, NodeKind root, const NodeSource& nodes);
  void list(const std::vector<NodeDefinition>& nodes) { out_.list(nodes); }
  void add(const TracedRay& ray);
  void finish(EncodedGroup& group) { out_.finish(group); }

 private:
  void require(bool holds, const char* rule) { out_.place().require(holds, rule); }
  [[noreturn, gnu::cold, gnu::noinline]] void fail_at(const Event* event, const char* rule) {
    out_.place().event = static_cast<std::size_t>(event - round_events_);
    out_.place().fail(rule);
  }
  void require(bool holds, const Event* event, const char* rule) {
    if (!holds) [[unlikely]]
      fail_at(event, rule);
  }

  void put_events(const Round& round, std::span<const Event> events);
  void pop_leaf(const Event* event, ChildPlace at, const InstancePath& path);
  StackFrame pop_inner(const Event* event, ChildPlace at, const InstancePath& path);
  void checkpoint(ChildPlace at, const InstancePath& path) { write({at.parent(), at.slot(), path}); }
  void write(const NodeReference& entry);
  void take_instance(const Event* event, std::uint32_t leaf);
  bool read_source(const Event* event, StackFrame& taken);

  PopEncoder out_;
  const GroupModel& model_ = out_.model();
  const InstanceLevels& levels_ = model_.levels();
  bool two_level_ = false;
  bool hides_ = false;  ///< the header's opacity_bound
  ReadOrder read_order_;
  PopOrder pop_order_;
  const Event* round_events_ = nullptr;
  std::vector<StackFrame> frames_;
  std::vector<NodeReference> source_;
  std::vector<NodeReference> destination_;
  std::size_t taken_ = 0;         ///< source entries read in this round
  std::int64_t last_taken_ = -1;  ///< position of the last entry read
  SourceAssignment assignment_;
  std::vector<std::uint32_t> addresses_;                  ///< order nearest: addresses of the source entries
  const std::vector<std::uint32_t>* assigned_ = nullptr;  ///< order nearest: position of each read
  bool has_bins_ = false;
  BinnedEntries<NodeReference> binned_;  ///< replaces source_ and destination_
  std::span<const std::uint8_t> bins_;   ///< bins of the ray's entries not written yet
};

void GroupEncoder::Impl::begin(const Header& header, std::uint32_t index, RayKind kind, NodeKind root,
                               const NodeSource& nodes) {
  out_.begin(header, index, kind, root, nodes);
  two_level_ = header.two_level;
  hides_ = header.opacity_bound == OpacityBound::on;
  read_order_ = ReadOrder(header.checkpoint_order);
  pop_order_ = PopOrder(header.child_order);
  has_bins_ = header.checkpoint_bins != 0;
  binned_ = BinnedEntries<NodeReference>(header.checkpoint_bins, header.checkpoint_capacity);
}

void GroupEncoder::Impl::add(const TracedRay& ray) {
  out_.begin_ray();
  out_.reserve(ray.events.size() + ray.rounds.size());
  destination_.clear();
  bins_ = ray.bins;
  std::size_t next_event = 0;
  std::size_t processed = 0;
  GroupPlace& place = out_.place();
  for (place.round = 0; place.round < ray.rounds.size(); ++place.round) {
    const Round& round = ray.rounds[place.round];
    require(round.event_count <= ray.events.size() - next_event, "event_count exceeds the ray's events");
    require(round.processed_count <= ray.processed.size() - processed, "processed_count exceeds the ray's entries");
    require(round.overflow || round.eviction_dropped == 0, "evictions are only dropped by an overflow");
    out_.begin_round();
    put_events(round, ray.events.subspan(next_event, round.event_count));
    out_.end_round(round);
    next_event += round.event_count;
    processed += round.processed_count;
  }
  place.round = GroupPlace::kNowhere;
  require(next_event == ray.events.size(), "events remain behind the last round");
  require(processed == ray.processed.size(), "processed entries remain behind the last round");
  require(bins_.empty(), "bins must be those of the checkpoint entries written");
  out_.end_ray(ray.pixel, ray.rounds.size(), ray.processed);
}

void GroupEncoder::Impl::put_events(const Round& round, std::span<const Event> events) {
  round_events_ = events.data();
  source_.clear();
  if (round.replay) source_.swap(destination_);
  destination_.clear();
  taken_ = 0;
  last_taken_ = -1;
  const bool ordered = has_bins_ && round.replay;
  require(ordered ? binned_.places().allows(round.bins) : round.bins == BinOrder{}, "a replay reads bins that exist");
  binned_.begin_round(round.replay, round.bins);
  if (ordered) out_.bin_order(round.bins);
  if (!read_order_.by_place() && round.replay) {
    addresses_.clear();
    for (const NodeReference& entry : source_) addresses_.push_back(model_[entry.parent].child_address(entry.slot));
    assigned_ = &assignment_.assign(addresses_, source_, events, levels_);
  }
  StackFrame top{GroupModel::kRootParent, {}, round.replay ? 0U : 1U};
  frames_.clear();  // frames below the top one
  const Event* const end = events.data() + events.size();
  for (const Event* event = events.data(); event != end; ++event) {
    if (top.remaining == 0) {
      if (frames_.empty()) {
        if (!read_source(event, top)) continue;
        const std::uint32_t taken = event->node;
        const bool scene = levels_.is_object(taken), instance = levels_.is_blas(taken);
        require(end - event > (scene ? 1 : 0) + (instance ? 1 : 0), event,
                "visit_instance must follow the take of a node inside an instance");
        if (scene) take_instance(++event, top.path.scene);
        if (instance) take_instance(++event, top.path.instance);
        continue;
      }
      top = frames_.back();
      frames_.pop_back();
    }
    const NodeModel& parent = model_[top.parent];
    const unsigned first = NodeModel::first_of(parent.ordered(top.remaining));
    unsigned slot = first;
    if (parent.child_address(first) != event->node) {
      slot = parent.slot_of(top.remaining, event->node);
      require(slot < kMaxWidth, event, "the node is not on top of the stack");
      require(!pop_order_.by_slots(), event, "children must be popped in the header's child order");
    }
    const ChildPlace at = out_.pop(top.parent, top.remaining, slot);
    top.remaining &= ~(1U << slot);
    if (event->kind() == EventKind::visit_leaf) {
      pop_leaf(event, at, top.path);
      continue;
    }
    StackFrame pushed = pop_inner(event, at, top.path);
    if (pushed.remaining == 0) continue;
    if (top.remaining != 0) frames_.push_back(top);
    if (StackFrame rest; pop_order_.split(pushed, model_[pushed.parent].internal_mask, rest)) frames_.push_back(rest);
    top = pushed;
  }
  require(top.remaining == 0 && frames_.empty(), "the stack must be empty at the end of a round");
  require(taken_ == source_.size() || has_bins_, "every source entry must be read");
  if (has_bins_ && binned_.more()) out_.stop();
  if (round.overflow) destination_.clear();
}

void GroupEncoder::Impl::write(const NodeReference& entry) {
  if (!has_bins_) return destination_.push_back(entry);
  require(!bins_.empty() && bins_[0] < binned_.places().count() && !binned_.places().full(bins_[0]),
          "an entry must be written to a bin that exists and has room");
  out_.bin(bins_[0]);
  binned_.write(bins_[0], entry);
  bins_ = bins_.subspan(1);
}

// Handles the event after the take of a node below the instance leaf at `leaf`: the visit of that leaf.
void GroupEncoder::Impl::take_instance(const Event* event, std::uint32_t leaf) {
  out_.instance_of_taken();
  require(event->kind() == EventKind::visit_instance && event->detail == 1 && event->node == leaf &&
              event->checkpoints == 0 && event->shifts() == 0,
          event, "must be the visit of the instance leaf through which the taken node was reached (detail 1)");
}

void GroupEncoder::Impl::pop_leaf(const Event* event, ChildPlace at, const InstancePath& path) {
  const NodeModel& parent = model_[at.parent()];
  require((parent.internal_mask >> at.slot() & 1) == 0 && !parent.is_instance(at.slot()), event,
          "no leaf is on top of the stack");
  require(event->detail <= static_cast<unsigned>(kLastLeafOutcome), event, "the leaf outcome must be known");
  if (event->checkpoints != 0 && !(hides_ && may_shift(event->outcome()))) {
    require(event->checkpoints == 1 && event->outcome() == LeafOutcome::beyond, event,
            "only a leaf beyond t_max is checkpointed");
    checkpoint(at, path);
  }
  require(may_shift(event->outcome()) || event->shifts() == 0, event, "only an insertion shifts");
  out_.leaf(at, event->outcome(), event->checkpoints, event->shifts());
}

/// Returns the pushed frame, which may be empty.
StackFrame GroupEncoder::Impl::pop_inner(const Event* event, ChildPlace at, const InstancePath& path) {
  const unsigned slot = at.slot();
  if (event->kind() == EventKind::visit_internal) {
    require(model_[at.parent()].is_internal(slot), event, "no internal node is on top of the stack");
    const std::uint32_t index = out_.reach(at, event->node);
    const unsigned hits = event->pushed() | event->checkpoints;
    require(((event->pushed() & event->checkpoints) | hits >> model_[index].child_count | event->shifts()) == 0, event,
            "a visit pushes or checkpoints children that exist, each once, and shifts nothing");
    out_.internal(at, index, event->pushed(), event->checkpoints);
    for (unsigned left = event->checkpoints; left != 0; left &= left - 1) {
      checkpoint({index, static_cast<unsigned>(std::countr_zero(left))}, path);
    }
    return {index, path, event->pushed()};
  }
  if (event->kind() == EventKind::cull) {
    require(event->detail == 0 && event->shifts() == 0, event, "a cull has no detail and no shifts");
    require(event->checkpoints <= 1, event, "a cull writes at most one checkpoint");
    if (event->checkpoints != 0) checkpoint(at, path);
    out_.cull(at, event->checkpoints);
    return {};
  }
  require(event->kind() == EventKind::visit_instance && event->detail == 0 && model_[at.parent()].is_instance(slot),
          event, "the event does not handle the node on top of the stack");
  require(two_level_, event, "instance leaves need a two-level structure");
  require(event->checkpoints == 0 && event->shifts() == 0, event,
          "the visit of an instance leaf has no checkpoints, no shifts");
  const std::uint32_t root = levels_.root_below(event->node);
  require(root != InstanceLevels::kNoRoot, event, "the leaf of a scene TLAS must be one of the header's scene_leaves");
  out_.instance(at);
  return {root, levels_.below(path, event->node), 1};
}

/// Returns whether the entry was taken; if so, its frame is in `taken`.
bool GroupEncoder::Impl::read_source(const Event* event, StackFrame& taken) {
  const bool take = event->kind() == EventKind::replay_take;
  require(take || event->kind() == EventKind::replay_forward, event,
          "the stack is empty: only a source entry can come next");
  require(has_bins_ ? binned_.more() : taken_ < source_.size(), event, "no source entry is left to read");
  std::size_t index = read_order_.position(taken_, source_.size());
  if (!read_order_.by_place()) {
    require((*assigned_)[taken_] != SourceAssignment::kNone, event, "no unread source entry has this address");
    index = (*assigned_)[taken_];
    out_.source_position(static_cast<std::int64_t>(index) - last_taken_ - 1);
    last_taken_ = static_cast<std::int64_t>(index);
  }
  ++taken_;
  const NodeReference entry = has_bins_ ? binned_.read() : source_[index];
  require(event->node == model_[entry.parent].child_address(entry.slot), event, "must read the next source entry");
  require(event->detail == 0 && event->shifts() == 0, event, "a replay event has no detail and no shifts");
  require(event->checkpoints <= (take ? 0 : 1), event, "a forward writes at most one checkpoint, a take none");
  if (take) {
    out_.take();
    taken = {entry.parent, entry.path, 1U << entry.slot};
    return true;
  }
  out_.forward(event->checkpoints);
  if (event->checkpoints != 0) write(entry);
  return false;
}

GroupEncoder::GroupEncoder() : impl_(std::make_unique<Impl>()) {}
GroupEncoder::~GroupEncoder() = default;
GroupEncoder::GroupEncoder(GroupEncoder&&) noexcept = default;
GroupEncoder& GroupEncoder::operator=(GroupEncoder&&) noexcept = default;

void GroupEncoder::begin(const Header& header, std::uint32_t index, RayKind kind, NodeKind root,
                         const NodeSource& nodes) {
  impl_->begin(header, index, kind, root, nodes);
}
void GroupEncoder::add(const TracedRay& ray) { impl_->add(ray); }
void GroupEncoder::list(const std::vector<NodeDefinition>& nodes) { impl_->list(nodes); }
void GroupEncoder::finish(EncodedGroup& group) { impl_->finish(group); }

}  // namespace grtx::traces
