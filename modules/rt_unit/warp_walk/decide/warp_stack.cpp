// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/warp_walk/decide/warp_stack.h"

#include <algorithm>
#include <bit>
#include <cassert>

#include "grtx/modules/rt_unit/decide/event_effect.h"
#include "grtx/modules/rt_unit/decide/node_visit.h"

namespace grtx::modules {

using traces::Event;
using traces::EventKind;
using traces::NodeKind;

std::uint32_t LaneTree::address(std::uint32_t index) const {
  const Event& event = events_[index];
  return event.kind() == EventKind::visit_internal ? group_->nodes[event.node].address : event.node;
}

const char* LaneTree::build(std::span<const Event> events, const traces::RayGroup& group, const NodeTraffic& traffic) {
  events_ = events;
  group_ = &group;
  end_.assign(events.size(), 0);
  kind_.assign(events.size(), NodeKind::internal);
  open_.clear();
  const auto units = [&](NodeKind kind) { return traffic.stored_units(kind); };
  for (std::uint32_t e = 0; e < events.size(); ++e) {
    const Event& event = events[e];
    const bool internal = event.kind() == EventKind::visit_internal;
    if (!internal && event.kind() != EventKind::visit_leaf && event.kind() != EventKind::cull) return kRuleWalkedKinds;
    if (internal && event.node >= group.nodes.size()) return rule_of_missing_node(event);
    if (EventEffect(event).checkpoints() != 0) return kRuleEntriesNeedCheckpoints;
    kind_[e] = internal ? NodeKind::internal : traffic.leaf_kind();
    if (e > 0) {
      if (open_.empty()) return kRuleNodeOnStack;
      const traces::NodeDefinition& parent = group.nodes[events[open_.back().event].node];
      const unsigned slot = child_slot(parent, address(e), units);
      if (slot == traces::kMaxWidth || (open_.back().waiting >> slot & 1) == 0) return kRuleChildPushed;
      open_.back().waiting &= ~(1u << slot);
      const NodeKind child = parent.child_kinds[slot];
      kind_[e] = child == NodeKind::internal || traces::is_wide(child) ? child : traffic.leaf_kind();
    }
    if (internal && event.pushed() != 0) {
      open_.push_back({e, event.pushed()});
      continue;
    }
    end_[e] = e + 1;
    for (; !open_.empty() && open_.back().waiting == 0; open_.pop_back()) end_[open_.back().event] = e + 1;
  }
  return open_.empty() ? nullptr : kRuleNothingLeft;
}

void WarpStack::begin(const WarpStackEntry& root) {
  assert(empty() && under_way_ == 0);
  order_.push_back({root, -1});
  waiting_ = 1;
}

std::size_t WarpStack::next(unsigned room, NodeKind leaf) const {
  if (!has_slot()) return kNone;
  const std::size_t lowest = window_ == 0 || window_ > order_.size() ? 0 : order_.size() - window_;
  for (std::size_t place = order_.size(); place-- > lowest;) {
    const Item& item = order_[place];
    if (item.slot >= 0) continue;
    if (traces::without_width(item.entry.kind) != leaf ||
        static_cast<unsigned>(std::popcount(item.entry.lanes)) <= room)
      return place;
  }
  return kNone;
}

unsigned WarpStack::start(std::size_t place) {
  unsigned slot = 0;
  while (nodes_[slot].used) ++slot;
  Item& item = order_[place];
  nodes_[slot] = {item.entry, item.entry.lanes, true, false, 0, item.entry.lanes, {}, 0};
  item.slot = static_cast<int>(slot);
  --waiting_;
  ++under_way_;
  return slot;
}

void WarpStack::drop(std::size_t place) {
  order_.erase(order_.begin() + static_cast<std::ptrdiff_t>(place));
  --waiting_;
}

std::size_t WarpStack::place_of(unsigned slot) const {
  std::size_t place = order_.size();
  while (order_[--place].slot != static_cast<int>(slot)) assert(place > 0);
  return place;
}

void WarpStack::finish(unsigned slot) {
  nodes_[slot].used = false;
  --under_way_;
  order_.erase(order_.begin() + static_cast<std::ptrdiff_t>(place_of(slot)));
}

bool WarpStack::write_child(unsigned slot) {
  Node& node = nodes_[slot];
  const auto parent = order_.begin() + static_cast<std::ptrdiff_t>(place_of(slot));
  const WarpStackEntry& child = node.children[node.written++];
  ++waiting_;
  if (node.written < node.children.size()) {
    order_.insert(parent + 1, {child, -1});
    return false;
  }
  *parent = {child, -1};
  node.used = false;
  --under_way_;
  return true;
}

StackSpill::Move WarpStack::settle(std::size_t more, bool top) {
  const std::uint32_t before = spilled_.in_memory;
  const StackSpill::Move move = spill_.settle(spilled_, depth() + static_cast<std::uint32_t>(more), top);
  if (move.fill) {
    const auto first = below_.end() - static_cast<std::ptrdiff_t>(before - spilled_.in_memory);
    coming_.assign(first, below_.end());
    below_.erase(first, below_.end());
    return move;
  }
  for (std::uint32_t i = before; i < spilled_.in_memory; ++i) {
    const auto lowest = std::find_if(order_.begin(), order_.end(), [](const Item& item) { return item.slot < 0; });
    below_.push_back(lowest->entry);
    order_.erase(lowest);
    --waiting_;
  }
  return move;
}

void WarpStack::filled() {
  waiting_ += static_cast<unsigned>(coming_.size());
  for (auto entry = coming_.rbegin(); entry != coming_.rend(); ++entry) order_.insert(order_.begin(), {*entry, -1});
  coming_.clear();
}

}  // namespace grtx::modules
