// Link: items appear after the latency, freed space a cycle later, whatever runs first in a cycle.
#include "modules/link.h"

#include <gtest/gtest.h>

namespace grtx::modules {
namespace {

TEST(LinkTest, ItemsBecomeVisibleAfterTheLatency) {
  for (const unsigned latency : {1u, 2u, 7u}) {
    Link<int> link("link", latency, 4);
    link.push(10, 42);
    EXPECT_EQ(link.front(10 + latency - 1), nullptr);
    ASSERT_NE(link.front(10 + latency), nullptr);
    EXPECT_EQ(*link.front(10 + latency), 42);
    EXPECT_EQ(link.next_visible(), 10 + latency);
    link.pop(10 + latency);
    EXPECT_TRUE(link.empty());
  }
}

TEST(LinkTest, SpaceFreedInACycleIsSeenInTheNext) {
  Link<int> link("link", 1, 2);
  link.push(0, 1);
  link.push(0, 2);
  EXPECT_FALSE(link.can_push(1));
  link.pop(1);
  EXPECT_FALSE(link.can_push(1)) << "the producer may have run before the consumer";
  EXPECT_TRUE(link.can_push(2));
  EXPECT_EQ(link.space(2), 1u);
  link.pop(2);
  EXPECT_EQ(link.space(2), 1u);
  EXPECT_EQ(link.space(3), 2u);
}

TEST(LinkTest, AnnouncesThatItIsNoLongerEmpty) {
  Link<int> link("link", 1, 4);
  std::uint64_t waiting = 0;
  link.announce(&waiting, 5);
  link.push(0, 1);
  EXPECT_EQ(waiting, 32u);
  waiting = 0;
  link.push(1, 2);
  EXPECT_EQ(waiting, 0u) << "it was not empty";
  link.pop(2);
  link.pop(2);
  link.push(3, 3);
  EXPECT_EQ(waiting, 32u);
}

TEST(LinkTest, OneItemACycleFlowsThroughTwoPlaces) {
  // Capacity for full rate: latency + 1, because credits return a cycle late.
  Link<int> link("link", 1, 2);
  int sent = 0;
  int received = 0;
  for (Cycle now = 0; now < 100; ++now) {
    const auto consume = [&] {
      if (link.front(now) == nullptr) return;
      EXPECT_EQ(*link.front(now), received++);
      link.pop(now);
    };
    const auto produce = [&] {
      if (link.can_push(now)) link.push(now, sent++);
    };
    if (now % 2 == 0) {
      produce();
      consume();
    } else {
      consume();
      produce();
    }
  }
  EXPECT_EQ(sent, 100);
  EXPECT_EQ(received, 99);
}

}  // namespace
}  // namespace grtx::modules
