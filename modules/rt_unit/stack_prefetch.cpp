#include "grtx/modules/rt_unit/stack_prefetch.h"

#include "grtx/modules/rt_unit/node_visit.h"

namespace grtx::modules {

using traces::Event;
using traces::EventKind;

StackPrefetch::StackPrefetch(std::size_t lanes, const Config& config, const NodeTraffic& traffic)
    : config_(config), traffic_(traffic), lanes_(config.depth > 0 ? lanes : 0) {}

// A trace has no stack, but each entry is taken once, so the event that takes it stands for it, and pushes and pops
// match like parentheses. From the last event back: before an event its entry lies on what is left below those that it
// pushes. Only what lies on the stack at a time is ever asked for, so nothing is known ahead that hardware would not
// know.
void StackPrefetch::begin(std::size_t lane, const traces::RayGroup& group, std::span<const Event> events) {
  Lane& l = lanes_[lane];
  l.group = &group;
  l.events = events;
  l.pops = 0;
  l.entries.assign(events.size(), {});
  for (std::size_t i = events.size(); i-- > 0;) {
    const EventEffect effect(events[i]);
    if (!effect.takes_top()) continue;
    std::uint32_t top = top_after(l, i);
    // The root of the tree below an instance leaf takes the leaf's place.
    const unsigned over = effect.pushed() + (effect.popped() == 0 ? 1 : 0);
    for (unsigned child = 0; child < over && top != kNone; ++child) {
      if (events[top].kind() == EventKind::cull && events[i].kind() == EventKind::visit_internal &&
          events[i].node < group.nodes.size()) {
        const traces::NodeDefinition& parent = group.nodes[events[i].node];
        const unsigned slot =
            child_slot(parent, events[top].node, [&](auto kind) { return traffic_.stored_units(kind); });
        if (slot < traces::kMaxWidth) l.entries[top].kind = parent.child_kinds[slot];
      }
      top = l.entries[top].below;
    }
    l.entries[i].below = top;
  }
}

bool StackPrefetch::triggered(Lane& lane, const EventEffect& effect) const {
  const bool rises = effect.popped() > 0 && effect.pushed() == 0;
  lane.pops = rises ? lane.pops + 1 : 0;
  return config_.trigger == StackTrigger::pop ? lane.pops >= config_.pops : effect.pushed() > 1;
}

StackPrefetch::Node StackPrefetch::node(const Lane& lane, std::uint32_t entry) const {
  const Event& event = lane.events[entry];
  if (const auto visit = node_visit(event, *lane.group, traffic_)) return {visit->kind, visit->address, false};
  return {lane.entries[entry].kind, traffic_.address(event.node), true};
}

}  // namespace grtx::modules
