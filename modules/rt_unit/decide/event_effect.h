// What an event of a trace does to its lane, beside taking time: its stack, its checkpoint entries, a call of the
// any-hit shader. The one place where that is decided, with and without time.
#pragma once

#include <bit>
#include <cstdint>
#include <span>

#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

// Rules that a trace turns out to break when it is executed, as errors name them.
inline constexpr const char* kRuleNodeOnStack = "takes a node from an empty stack";
inline constexpr const char* kRuleReplayNeedsCheckpoints = "replays although checkpointing is off";
inline constexpr const char* kRuleEntriesNeedCheckpoints = "writes checkpoint entries although checkpointing is off";

class EventEffect {
 public:
  explicit EventEffect(const traces::Event& event) : event_(event) {}

  /// Takes the lane's next source entry. All other events handle the node on top of its stack.
  bool replays() const { return kind() == Kind::replay_take || kind() == Kind::replay_forward; }
  bool takes_top() const { return !replays(); }
  /// A leaf whose hit the any-hit shader must see before the lane goes on.
  bool calls_any_hit() const { return kind() == Kind::visit_leaf && traces::calls_any_hit(event_.outcome()); }
  /// A leaf that some shader must see. boxes: leaves are boxes, for which the intersection shader is called.
  bool calls_shader(bool boxes) const { return boxes ? kind() == Kind::visit_leaf : calls_any_hit(); }
  /// An instance leaf stays: the BLAS root takes its place, or the BLAS node that was replayed lies on top.
  unsigned popped() const { return takes_top() && kind() != Kind::visit_instance ? 1 : 0; }
  unsigned pushed() const {
    if (kind() == Kind::visit_internal) return static_cast<unsigned>(std::popcount(event_.pushed()));
    return kind() == Kind::replay_take ? 1 : 0;
  }
  /// Entries for the lane's destination buffer, written when the event is done.
  unsigned checkpoints() const {
    switch (kind()) {
      case Kind::visit_internal:
        return static_cast<unsigned>(std::popcount(unsigned{event_.checkpoints}));
      case Kind::visit_leaf:
        return traces::calls_any_hit(event_.outcome()) ? 0 : event_.checkpoints;
      case Kind::cull:
      case Kind::replay_forward:
        return event_.checkpoints;
      default:
        return 0;
    }
  }
  /// The depth of the stack after the event. False: the event needs a node and there is none (kRuleNodeOnStack).
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

/// Entries that the events of a round read from the source buffer: a round that replays reads all there are.
inline std::uint32_t source_entries(std::span<const traces::Event> events) {
  std::uint32_t entries = 0;
  for (const traces::Event& event : events) entries += EventEffect(event).replays() ? 1 : 0;
  return entries;
}

/// The lane, whose event is `event`, is one of those that a shader is called for.
inline void add_lane(AnyHitBatch& batch, unsigned lane, const traces::Event& event) {
  batch.lanes |= bit(lane);
  batch.outcome[lane] = event.outcome();
  batch.shifts[lane] = static_cast<std::uint16_t>(event.shifts());
  batch.leaf[lane] = event.node;
}

}  // namespace grtx::modules
