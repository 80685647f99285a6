// SPDX-License-Identifier: Apache-2.0
// Which request a warp serves next: any-hit shaders before node fetches, each kind in order of arrival.
#include "grtx/modules/simt/decide/service_order.h"

#include <gtest/gtest.h>

namespace grtx::modules {
namespace {

AnyHitBatch any_hit(std::uint16_t slot, LaneMask lanes) {
  AnyHitBatch batch;
  batch.slot = slot;
  batch.lanes = lanes;
  return batch;
}

NodeFetchBatch node_fetch(std::uint16_t slot, std::uint16_t entry) { return {slot, entry, 1, {}}; }

TEST(ServiceOrder, AnyHitShadersComeBeforeNodeFetchesThatCameEarlier) {
  ServiceOrder order;
  order.add(node_fetch(3, 7));
  order.add(any_hit(3, 1));
  EXPECT_EQ(order.take_any_hit(3).value().lanes, 1u);
  EXPECT_FALSE(order.take_any_hit(3).has_value());
  EXPECT_EQ(order.take_node_fetch(3).value().entry, 7u);
  EXPECT_TRUE(order.empty());
}

TEST(ServiceOrder, EachKindIsServedInOrderOfArrival) {
  ServiceOrder order;
  for (const LaneMask lanes : {4, 2, 8}) order.add(any_hit(0, lanes));
  for (const std::uint16_t entry : {std::uint16_t{9}, std::uint16_t{5}}) order.add(node_fetch(0, entry));
  for (const LaneMask lanes : {4, 2, 8}) EXPECT_EQ(order.take_any_hit(0).value().lanes, lanes);
  for (const unsigned entry : {9u, 5u}) EXPECT_EQ(order.take_node_fetch(0).value().entry, entry);
}

TEST(ServiceOrder, ARequestIsServedByItsOwnWarp) {
  ServiceOrder order;
  order.add(any_hit(1, 1));
  order.add(node_fetch(2, 0));
  EXPECT_FALSE(order.waits(0));
  EXPECT_TRUE(order.waits(1));
  EXPECT_TRUE(order.waits(2));
  EXPECT_FALSE(order.take_any_hit(2).has_value());
  EXPECT_TRUE(order.take_node_fetch(2).has_value());
  EXPECT_FALSE(order.waits(2));
  EXPECT_EQ(order.any_hits(), 1u);
  EXPECT_EQ(order.node_fetches(), 0u);
}

}  // namespace
}  // namespace grtx::modules
