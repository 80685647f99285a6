// SPDX-License-Identifier: Apache-2.0
// The tests that a node needs with a beam around its warp's rays. docs/model/warp_walk.md, "Beam".
#include "grtx/modules/rt_unit/warp_walk/decide/warp_beam.h"

#include <gtest/gtest.h>

namespace grtx::modules {
namespace {

TEST(WarpBeam, ComesFirstForManyLanes) {
  const BeamTests beam({true, 4, 2}, 6, 4, 0);
  EXPECT_FALSE(beam.comes_first(0b111));
  EXPECT_TRUE(beam.comes_first(0b1111));
  EXPECT_FALSE(BeamTests({false, 4, 2}, 6, 4, 0).comes_first(~LaneMask{0}));
}

TEST(WarpBeam, LanesShareATestThatHasBoxesForThem) {
  const BeamTests two({true, 4, 2}, 6, 4, 0), six({true, 4, 6}, 6, 4, 0), one({true, 4, 6}, 1, 4, 0);
  const unsigned of_two[] = {2, 2, 2, 1, 1, 1}, of_six[] = {6, 3, 2, 1, 1, 1};
  for (unsigned met = 1; met <= 6; ++met) {
    EXPECT_EQ(two.lanes_together(met), of_two[met - 1]) << met;
    EXPECT_EQ(six.lanes_together(met), of_six[met - 1]) << met;
    EXPECT_EQ(one.lanes_together(met), 1u) << "a box a test";
  }
}

TEST(WarpBeam, ATestTakesTheLowestLanesWhoseRaysLieInBanksOfTheirOwn) {
  const BeamTests free({true, 4, 6}, 6, 4, 0), banks({true, 4, 6}, 6, 4, 4);
  EXPECT_EQ(free.next_lanes(0b101101, 2), 0b101u);
  EXPECT_EQ(free.next_lanes(0b100000, 2), 0b100000u);
  EXPECT_EQ(banks.next_lanes(0b1'0001'0001, 3), 0b1u) << "lanes 0, 4 and 8 are in one bank";
  EXPECT_EQ(banks.next_lanes(0b10'0011'0001, 3), 0b10'0001u) << "4 lies with 0, 9 with 5";
}

TEST(WarpBeam, StorageAndOperatorsAreThereOnlyIfItIs) {
  Inventory off, on;
  BeamTests({false, 4, 2}, 6, 4, 8).add_to(off, 8);
  EXPECT_TRUE(off.storage.empty() && off.operators.empty());
  BeamTests({true, 4, 2}, 6, 4, 8).add_to(on, 8);
  ASSERT_EQ(on.storage.size(), 1u);
  EXPECT_EQ(on.storage[0].bits, 8u * 3 * (4 * 32 + 1));
  EXPECT_EQ(on.operators.size(), 4u);
}

}  // namespace
}  // namespace grtx::modules
