// SPDX-License-Identifier: Apache-2.0
// A child order (traces/orders/child_order.h) as used by encoder, decoder and checker, which do not know t values.
#pragma once

#include <bit>
#include <cstdint>

#include "grtx/traces/codec/group_model.h"
#include "grtx/traces/orders/child_order.h"

namespace grtx::traces {

class PopOrder {
 public:
  explicit PopOrder(ChildOrder order = ChildOrder::near_first) {
    with_child_order(order, [this]<typename Policy>(Policy) {
      by_slots_ = Policy::kBySlots;
      followed_ = Policy::kFollows ? Policy::followed : nullptr;
      first_ = NodeModel::order_of(Policy{});
    });
  }

  /// Whether slots and kinds determine the order, so that pops are always as expected.
  bool by_slots() const { return by_slots_; }
  /// The slot popped next among `remaining` (not 0) of one visit. Requires by_slots().
  unsigned next(unsigned remaining) const { return NodeModel::first_of(first_ & NodeModel::bits_of_mask(remaining)); }
  /// A visit pushes `pushed`. If one of its children is visited before all others, moves the others to the frame `rest`
  /// below it and returns true. internal: mask of the node's internal children.
  bool split(StackFrame& pushed, unsigned internal, StackFrame& rest) const {
    if (followed_ == nullptr) return false;
    const std::uint32_t first = followed_(pushed.remaining, internal);
    if (first == 0 || first == pushed.remaining) return false;
    rest = {pushed.parent, pushed.path, pushed.remaining & ~first};
    pushed.remaining = first;
    return true;
  }

 private:
  bool by_slots_ = false;
  unsigned (*followed_)(unsigned pushed, unsigned internal) = nullptr;
  std::uint64_t first_ = 0;  ///< initial NodeModel::order
};

}  // namespace grtx::traces
