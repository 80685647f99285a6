// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/ray/handled_order.h"

#include <bit>

#include "grtx/traces/rules/ahead_stack.h"

namespace grtx::report {
namespace {

using traces::Event;
using traces::EventKind;

std::vector<std::vector<std::uint32_t>> children_of(std::span<const Event> events) {
  struct Open {
    std::size_t event;
    int left;  ///< children that are still to come
  };
  std::vector<std::vector<std::uint32_t>> children(events.size());
  std::vector<Open> open;
  for (std::size_t e = 0; e < events.size(); ++e) {
    while (!open.empty() && open.back().left == 0) open.pop_back();
    if (!open.empty()) {
      children[open.back().event].push_back(static_cast<std::uint32_t>(e));
      --open.back().left;
    }
    if (events[e].kind() == EventKind::visit_internal) open.push_back({e, std::popcount(events[e].pushed())});
  }
  return children;
}

}  // namespace

HandledOrder handled_order(std::span<const Event> events, unsigned ahead) {
  HandledOrder order;
  order.children = children_of(events);
  if (events.empty()) return order;
  traces::AheadStack<std::uint32_t> stack(ahead);
  stack.begin(0);
  while (true) {
    stack.start([&](std::uint32_t event) {
      const bool starts = events[event].kind() != EventKind::cull;
      if (!starts) order.events.push_back(event);
      return starts;
    });
    if (stack.empty()) return order;
    const std::uint32_t event = stack.take();
    order.events.push_back(event);
    for (const std::uint32_t child : order.children[event]) stack.push(child);
  }
}

}  // namespace grtx::report
