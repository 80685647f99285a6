// SPDX-License-Identifier: Apache-2.0
// Where in the queue a fetch goes when the oldest warp is issued first.
#include "grtx/modules/rt_unit/memory_scheduler/decide/issue_order.h"

#include <gtest/gtest.h>

#include <vector>

namespace grtx::modules {
namespace {

std::size_t place(std::uint64_t age, const std::vector<WaitingFetch>& queue) {
  return oldest_first_place(age, queue.size(), [&](std::size_t i) { return queue.at(i); });
}

TEST(OldestFirst, AFetchGoesBeforeThoseOfYoungerWarps) {
  EXPECT_EQ(place(1, {{0, false}, {2, false}, {3, false}}), 1u);
  EXPECT_EQ(place(0, {{2, false}, {3, false}}), 0u);
}

TEST(OldestFirst, AFetchStaysBehindThoseOfItsOwnAndOfOlderWarps) {
  EXPECT_EQ(place(2, {{1, false}, {2, false}, {2, false}}), 3u);
  EXPECT_EQ(place(2, {{1, false}, {2, false}, {2, false}, {5, false}}), 3u);
}

TEST(OldestFirst, AFetchThatHasBegunIsFinished) {
  EXPECT_EQ(place(0, {{7, true}, {8, false}}), 1u);
  EXPECT_EQ(place(0, {{7, true}}), 1u);
}

TEST(OldestFirst, TheFirstFetchIsAtTheFront) { EXPECT_EQ(place(4, {}), 0u); }

}  // namespace
}  // namespace grtx::modules
