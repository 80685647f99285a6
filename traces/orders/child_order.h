// SPDX-License-Identifier: Apache-2.0
// Policies for the order in which the hit children of a node are visited, one file each in this folder, shared by
// tracer and trace codec. Templates, because the tracer's innermost loop uses them for each child of each node.
#pragma once

#include <concepts>
#include <utility>

#include "grtx/traces/modes.h"
#include "grtx/traces/orders/near_first.h"
#include "grtx/traces/orders/slot_order.h"
#include "grtx/traces/orders/vulkan_sim_order.h"

namespace grtx::traces {

/// kBySlots: slots and kinds of the pushed children determine the order, so a trace does not store it.
/// place(slot, hit, rank): number of children in the mask `hit` that are visited before the one in `slot`; rank: number
/// of them that the ray enters before it. followed(pushed, internal): mask of the one child that is visited before all
/// others, whatever its place(); 0 if there is none. internal: mask of the node's internal children.
template <typename Policy>
concept ChildOrderPolicy = requires(unsigned slot, unsigned mask, unsigned rank) {
  { Policy::kName } -> std::convertible_to<ChildOrder>;
  { Policy::kBySlots } -> std::convertible_to<bool>;
  { Policy::kFollows } -> std::convertible_to<bool>;
  { Policy::place(slot, mask, rank) } -> std::same_as<unsigned>;
  { Policy::followed(mask, mask) } -> std::same_as<unsigned>;
};
static_assert(ChildOrderPolicy<NearFirst> && ChildOrderPolicy<SlotOrder> && ChildOrderPolicy<VulkanSimOrder>);

/// Calls f with an object of the policy for `order`.
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
