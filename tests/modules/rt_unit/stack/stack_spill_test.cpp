// SPDX-License-Identifier: Apache-2.0
// Which stack entries move between warp buffer and memory: a sector at a time, as few as needed, none ahead of need.
#include "grtx/modules/rt_unit/stack/decide/stack_spill.h"

#include <gtest/gtest.h>

#include "grtx/modules/rt_unit/stack/decide/stack_entry.h"

namespace grtx::modules {
namespace {

TEST(StackSpill, SpillsAsManySectorsAsTheDepthExceedsTheChip) {
  const StackSpill spill(3, 2);
  StackSpill::Lane lane;
  EXPECT_FALSE(spill.settle(lane, 3, true).any());
  StackSpill::Move move = spill.settle(lane, 6, true);  // 6 - 3 = 3 too many: two sectors
  EXPECT_EQ(move.spills, 2u);
  EXPECT_EQ(move.first, 0u);
  EXPECT_EQ(lane.in_memory, 4u);
  move = spill.settle(lane, 8, true);  // four on chip
  EXPECT_EQ(move.spills, 1u);
  EXPECT_EQ(move.first, 2u);
  EXPECT_EQ(lane.in_memory, 6u);
}

TEST(StackSpill, FillsOnlyWhatTheNextEventTakes) {
  const StackSpill spill(2, 2);
  StackSpill::Lane lane;
  EXPECT_EQ(spill.settle(lane, 4, true).spills, 1u);
  EXPECT_FALSE(spill.settle(lane, 3, true).any()) << "one entry is still on chip";
  EXPECT_FALSE(spill.settle(lane, 2, false).any()) << "none is, but nobody asks for it";
  const StackSpill::Move move = spill.settle(lane, 2, true);
  EXPECT_TRUE(move.fill);
  EXPECT_EQ(move.spills, 0u);
  EXPECT_EQ(move.first, 0u);
  EXPECT_EQ(lane.in_memory, 0u);
}

TEST(StackSpill, MovesFourSmallerEntriesAtATime) {
  const StackSpill spill(4, 4);
  StackSpill::Lane lane;
  EXPECT_FALSE(spill.settle(lane, 4, true).any());
  StackSpill::Move move = spill.settle(lane, 9, true);  // 5 too many: two sectors
  EXPECT_EQ(move.spills, 2u);
  EXPECT_EQ(lane.in_memory, 8u);
  EXPECT_FALSE(spill.settle(lane, 9, true).any());
  move = spill.settle(lane, 8, true);
  EXPECT_TRUE(move.fill);
  EXPECT_EQ(move.first, 1u);
  EXPECT_EQ(lane.in_memory, 4u);
}

// 8 B address and 4 B t, padded to a power of two so that entries divide a sector of 32 B.
TEST(StackEntryLayout, FollowsFromThePopTest) {
  const StackEntryLayout with_t = stack_entry_layout(traces::PopTest::on);
  EXPECT_EQ(with_t.bits, 96u);
  EXPECT_EQ(with_t.bytes, 16u);
  EXPECT_EQ(with_t.in_a_sector, 2u);
  const StackEntryLayout without = stack_entry_layout(traces::PopTest::off);
  EXPECT_EQ(without.bits, 64u);
  EXPECT_EQ(without.bytes, 8u);
  EXPECT_EQ(without.in_a_sector, 4u);
}

TEST(StackSpill, NeedsRoomForASectorOfEntries) {
  EXPECT_NO_THROW(StackSpill(4, 4));
  EXPECT_THROW(StackSpill(3, 4), Error);
}

}  // namespace
}  // namespace grtx::modules
