// Which stack entries move between warp buffer and memory: two at a time, as few as needed, none ahead of need.
#include "grtx/modules/rt_unit/stack_spill.h"

#include <gtest/gtest.h>

namespace grtx::modules {
namespace {

TEST(StackSpill, SpillsAsManySectorsAsTheDepthExceedsTheChip) {
  const StackSpill spill(3);
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
  const StackSpill spill(2);
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

}  // namespace
}  // namespace grtx::modules
