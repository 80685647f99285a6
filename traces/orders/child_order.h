// In which order the hit children of a node are visited: a policy, one file each in this folder. Tracer and trace codec
// ask the same classes. They are chosen at compile time: the tracer asks for each child of each node that it opens, in
// its innermost loop.
#pragma once

#include <concepts>
#include <utility>

#include "grtx/traces/modes.h"
#include "grtx/traces/orders/near_first.h"
#include "grtx/traces/orders/slot_order.h"
#include "grtx/traces/orders/vulkan_sim_order.h"

namespace grtx::traces {

/// kName: its name. kBySlots: slots and kinds of the children pushed tell the order, so a trace need not hold it.
/// place(slot, hit, rank): how many of the children `hit` (a mask) are visited before that in `slot`; rank: how many of
/// them the ray enters before it. followed(pushed, internal): mask of the one child that is visited before all others
/// pushed with it, whatever its place; 0: places decide. internal: mask of the node's internal children.
template <typename Policy>
concept ChildOrderPolicy = requires(unsigned slot, unsigned mask, unsigned rank) {
  { Policy::kName } -> std::convertible_to<ChildOrder>;
  { Policy::kBySlots } -> std::convertible_to<bool>;
  { Policy::kFollows } -> std::convertible_to<bool>;
  { Policy::place(slot, mask, rank) } -> std::same_as<unsigned>;
  { Policy::followed(mask, mask) } -> std::same_as<unsigned>;
};
static_assert(ChildOrderPolicy<NearFirst> && ChildOrderPolicy<SlotOrder> && ChildOrderPolicy<VulkanSimOrder>);

/// Calls f with the policy of that name.
template <typename F>
decltype(auto) with_child_order(ChildOrder order, F&& f) {
  switch (order) {
    case ChildOrder::slot:
      return std::forward<F>(f)(SlotOrder{});
    case ChildOrder::vulkan_sim:
      return std::forward<F>(f)(VulkanSimOrder{});
    case ChildOrder::near_first:
      break;
  }
  return std::forward<F>(f)(NearFirst{});
}

}  // namespace grtx::traces
