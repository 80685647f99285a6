// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/ray/handled_order.h"

#include <bit>

#include "grtx/traces/rules/ahead_stack.h"

namespace grtx::report {

using traces::Event;
using traces::EventKind;

namespace {

/// Whether the node of the event comes from the stack; else from the source buffer, or it stays where it is.
bool pops(const Event& event) {
  const EventKind kind = event.kind();
  if (kind == EventKind::visit_instance) return event.detail == 0;
  return kind != EventKind::replay_take && kind != EventKind::replay_forward;
}

int pushes(const Event& event) {
  switch (event.kind()) {
    case EventKind::visit_internal:
      return std::popcount(event.pushed());
    case EventKind::visit_instance:
      return event.detail == 0 ? 1 : 0;
    case EventKind::replay_take:
      return 1;
    default:
      return 0;
  }
}

}  // namespace

std::vector<std::vector<std::uint32_t>> children_of(std::span<const Event> events) {
  struct Open {
    std::size_t event;
    int left;  ///< children that are still to come
  };
  std::vector<std::vector<std::uint32_t>> children(events.size());
  std::vector<Open> open;
  for (std::size_t e = 0; e < events.size(); ++e) {
    if (pops(events[e])) {
      while (!open.empty() && open.back().left == 0) open.pop_back();
      if (!open.empty()) {
        children[open.back().event].push_back(static_cast<std::uint32_t>(e));
        --open.back().left;
      }
    }
    if (const int pushed = pushes(events[e]); pushed != 0) open.push_back({e, pushed});
  }
  return children;
}

HandledOrder handled_order(std::span<const Event> events, unsigned ahead) {
  HandledOrder order;
  order.started.resize(events.size() + 1);
  if (events.empty()) return order;
  const std::vector<std::vector<std::uint32_t>> children = children_of(events);
  traces::AheadStack<std::uint32_t> stack(ahead);
  stack.begin(0);
  while (true) {
    stack.start([&](std::uint32_t event) {
      const bool starts = events[event].kind() != EventKind::cull;
      if (starts) {
        order.started[order.events.size()].push_back(event);
      } else {
        order.events.push_back(event);
      }
      return starts;
    });
    if (stack.empty()) return order;
    const std::uint32_t event = stack.take();
    order.events.push_back(event);
    for (const std::uint32_t child : children[event]) stack.push(child);
  }
}

}  // namespace grtx::report
