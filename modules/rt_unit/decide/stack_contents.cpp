#include "grtx/modules/rt_unit/decide/stack_contents.h"

namespace grtx::modules {

using traces::Event;
using traces::EventKind;

// Pushes and pops match like parentheses. From the last event back: before an event its entry lies on what is left
// below those that it pushes.
void StackContents::begin(const traces::RayGroup& group, std::span<const Event> events, const NodeTraffic& traffic) {
  group_ = &group;
  traffic_ = &traffic;
  events_ = events;
  entries_.assign(events.size(), {});
  for (std::size_t i = events.size(); i-- > 0;) {
    const EventEffect effect(events[i]);
    if (!effect.takes_top()) continue;
    std::uint32_t top = top_after(i);
    // The root of the tree below an instance leaf takes the leaf's place.
    const unsigned over = effect.pushed() + (effect.popped() == 0 ? 1 : 0);
    for (unsigned child = 0; child < over && top != kNone; ++child) {
      if (culled(top) && events[i].kind() == EventKind::visit_internal && events[i].node < group.nodes.size()) {
        const traces::NodeDefinition& parent = group.nodes[events[i].node];
        const unsigned slot =
            child_slot(parent, events[top].node, [&](auto kind) { return traffic.stored_units(kind); });
        if (slot < traces::kMaxWidth) {
          const traces::NodeKind kind = parent.child_kinds[slot];
          const bool inner = kind == traces::NodeKind::internal || kind == traces::NodeKind::instance;
          entries_[top].kind = inner ? kind : traffic.leaf_kind();
        }
      }
      top = entries_[top].below;
    }
    entries_[i].below = top;
  }
}

NodeVisit StackContents::node(std::uint32_t entry) const {
  if (const auto visit = node_visit(events_[entry], *group_, *traffic_)) return *visit;
  const traces::NodeKind kind = entries_[entry].kind;
  return {kind, traffic_->address(events_[entry].node), kind == traces::NodeKind::instance && traffic_->header_read()};
}

}  // namespace grtx::modules
