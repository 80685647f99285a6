// SPDX-License-Identifier: Apache-2.0
// Effect of a trace event on its lane: stack, checkpoint entries, shader calls. Used by both the timed and the
// functional path.
#pragma once

#include <bit>
#include <cstdint>
#include <span>

#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

// Rules that execution checks in the trace; texts of the errors.
inline constexpr const char* kRuleNodeOnStack = "takes a node from an empty stack";
inline constexpr const char* kRuleReplayNeedsCheckpoints = "replays although checkpointing is off";
inline constexpr const char* kRuleEntriesNeedCheckpoints = "writes checkpoint entries although checkpointing is off";

class EventEffect {
 public:
  explicit EventEffect(const traces::Event& event) : event_(event) {}

  /// Whether the event takes the lane's next source entry. All other events handle the node on top of its stack.
  bool replays() const { return kind() == Kind::replay_take || kind() == Kind::replay_forward; }
  bool takes_top() const { return !replays(); }
  /// Whether the event is a leaf visit whose hit is passed to the any-hit shader before the lane continues.
  bool calls_any_hit() const { return kind() == Kind::visit_leaf && traces::calls_any_hit(event_.outcome()); }
  /// Whether any shader is called. boxes: leaves are boxes, for which the intersection shader is called.
  bool calls_shader(bool boxes) const { return boxes ? kind() == Kind::visit_leaf : calls_any_hit(); }
  /// Entries removed from the stack. An instance leaf keeps its entry: the BLAS root replaces it, or a replayed BLAS
  /// node is already on top.
  unsigned popped() const { return takes_top() && kind() != Kind::visit_instance ? 1 : 0; }
  unsigned pushed() const {
    if (kind() == Kind::visit_internal) return static_cast<unsigned>(std::popcount(event_.pushed()));
    return kind() == Kind::replay_take ? 1 : 0;
  }
  /// Entries to write to the lane's destination buffer when the event is done.
  unsigned checkpoints() const {
    const unsigned written = event_.written();
    return kind() == Kind::visit_internal ? static_cast<unsigned>(std::popcount(written)) : written;
  }
  /// Updates the stack depth. Returns false if the event needs a node but the stack is empty (kRuleNodeOnStack).
  template <typename Depth>
  [[nodiscard]] bool move_stack(Depth& depth) const {
    if (takes_top() && depth == 0) return false;
    depth = static_cast<Depth>(depth - popped() + pushed());
    return true;
  }

 private:
  using Kind = traces::EventKind;
  Kind kind() const { return event_.kind(); }

  traces::Event event_;
};

/// Number of source entries that the events of a round read; a replaying round reads all there are.
inline std::uint32_t source_entries(std::span<const traces::Event> events) {
  std::uint32_t entries = 0;
  for (const traces::Event& event : events) entries += EventEffect(event).replays() ? 1 : 0;
  return entries;
}

/// Address of the instance leaf in which the event's leaf lies: that of the last visit of one; without any the leaf's.
inline std::uint32_t instance_above(const traces::Event* event, const traces::Ray& ray) {
  for (const traces::Event* before = event; before != ray.events.data();) {
    --before;
    if (before->kind() == traces::EventKind::visit_instance) return before->node;
  }
  return event->node;
}

/// Adds a lane, whose event is `event`, to the batch.
inline void add_lane(AnyHitBatch& batch, unsigned lane, const traces::Event& event) {
  batch.lanes |= bit(lane);
  batch.outcome[lane] = event.outcome();
  batch.shifts[lane] = static_cast<std::uint16_t>(event.shifts());
  batch.hidden[lane] = static_cast<std::uint8_t>(event.hidden());
  batch.leaf[lane] = event.node;
}

}  // namespace grtx::modules
