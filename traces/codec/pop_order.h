// What encoder, decoder and checker of a group need of a child order, which see no t (traces/orders/child_order.h).
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

  /// Slots and kinds tell the order: nothing else is ever popped than what is expected.
  bool by_slots() const { return by_slots_; }
  /// The child popped next of those that remain of one visit (at least one). Only where by_slots().
  unsigned next(unsigned remaining) const { return NodeModel::first_of(first_ & NodeModel::bits_of_mask(remaining)); }
  /// A visit pushes `pushed`. True when one of these children comes before the others, which then lie below it as
  /// `rest`. internal: mask of the node's internal children.
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
  std::uint64_t first_ = 0;  ///< NodeModel::order of a node not visited yet
};

}  // namespace grtx::traces
