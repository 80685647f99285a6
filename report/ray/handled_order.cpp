// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/ray/handled_order.h"

#include <bit>

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

struct Waiting {
  std::size_t event = 0;
  bool started = false;
};

}  // namespace

HandledOrder handled_order(std::span<const Event> events, unsigned ahead) {
  HandledOrder order;
  order.children = children_of(events);
  if (events.empty()) return order;
  std::vector<Waiting> stack(1);       // the topmost last; what is under way keeps its place
  std::vector<std::size_t> under_way;  // the one started first is done first
  std::size_t done = 0;
  while (true) {
    for (std::size_t i = stack.size(); i-- > 0 && under_way.size() - done < ahead;) {
      if (stack[i].started) continue;
      if (events[stack[i].event].kind() == EventKind::cull) {
        order.events.push_back(stack[i].event);
        stack.erase(stack.begin() + static_cast<std::ptrdiff_t>(i));
        continue;
      }
      stack[i].started = true;
      under_way.push_back(stack[i].event);
    }
    if (done == under_way.size()) return order;
    const std::size_t event = under_way[done++];
    order.events.push_back(event);
    auto place = stack.begin();
    while (place->event != event) ++place;
    place = stack.erase(place);
    const std::vector<std::uint32_t>& children = order.children[event];
    for (const std::uint32_t child : children) place = stack.insert(place, {child, false});
  }
}

}  // namespace grtx::report
