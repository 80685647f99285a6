// SPDX-License-Identifier: Apache-2.0
// NodeModel::order is a list of the eight slots: a popped slot moves before the first of those left.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "grtx/traces/codec/group_model.h"

namespace grtx::traces {
namespace {

/// The same, plainly.
struct PlainList {
  std::vector<unsigned> slots{0, 1, 2, 3, 4, 5, 6, 7};

  std::vector<unsigned> left(unsigned remaining) const {
    std::vector<unsigned> expected;
    for (const unsigned slot : slots) {
      if ((remaining >> slot & 1) != 0) expected.push_back(slot);
    }
    return expected;
  }
  void move_up(unsigned remaining, unsigned slot) {
    const unsigned first = left(remaining).front();
    slots.erase(std::find(slots.begin(), slots.end(), slot));
    slots.insert(std::find(slots.begin(), slots.end(), first), slot);
  }
};

TEST(ExpectedOrder, FollowsThePlainList) {
  std::mt19937 random(1);
  for (unsigned run = 0; run < 50; ++run) {
    NodeModel model;
    PlainList list;
    for (unsigned step = 0; step < 200; ++step) {
      const unsigned remaining = 1 + static_cast<unsigned>(random() % 255);
      const std::vector<unsigned> expected = list.left(remaining);
      const std::uint64_t ordered = model.ordered(remaining);
      EXPECT_EQ(NodeModel::mask_of(ordered), remaining);
      ASSERT_EQ(NodeModel::first_of(ordered), expected.front());
      for (unsigned rank = 0; rank < expected.size(); ++rank) {
        ASSERT_EQ(model.slot_at(remaining, rank), expected[rank]);
        ASSERT_EQ(model.rank_of(remaining, expected[rank]), rank);
      }
      const auto rank = static_cast<unsigned>(random() % expected.size());
      if (rank == 0) continue;
      model.move_up(remaining, expected[rank]);
      list.move_up(remaining, expected[rank]);
    }
  }
}

}  // namespace
}  // namespace grtx::traces
