// SPDX-License-Identifier: Apache-2.0
// Why a warp waits: of the states of its lanes that which is first in a fixed order; and the stall that it makes a
// cycle.
#include "grtx/modules/rt_unit/warp_buffer/decide/warp_wait.h"

#include <gtest/gtest.h>

#include <array>

namespace grtx::modules {
namespace {

/// The states of lanes, in the order in which they decide.
constexpr std::array kStatesInOrder = {WarpWait::ready, WarpWait::memory, WarpWait::checkpoint,
                                       WarpWait::stack, WarpWait::unit,   WarpWait::any_hit};

/// The wait of a warp whose lane i is in state i of kStatesInOrder, for the lanes in `lanes`.
WarpWait wait_with(LaneMask lanes) {
  const auto in = [&](unsigned state) { return lanes & LaneMask{1} << state; };
  return wait_of(in(0), in(1), in(2), in(3), in(4), in(5));
}

TEST(WarpWaits, ForTheFirstStateThatALaneIsIn) {
  for (LaneMask lanes = 1; lanes < LaneMask{1} << kStatesInOrder.size(); ++lanes) {
    unsigned first = 0;
    while ((lanes >> first & 1) == 0) ++first;
    EXPECT_EQ(wait_with(lanes), kStatesInOrder.at(first)) << "lanes in states " << lanes;
  }
}

TEST(WarpWaits, ToRetireIfNoLaneIsLeft) { EXPECT_EQ(wait_with(0), WarpWait::retire); }

TEST(WarpWaits, ALaneInAUnitHidesThatAllOthersWaitForTheShader) {
  EXPECT_EQ(wait_of(0, 0, 0, 0, 1, 0xfffffffe), WarpWait::unit);
  EXPECT_EQ(wait_of(0, 0, 0, 0, 0, 0xffffffff), WarpWait::any_hit);
}

TEST(Stalls, AreNamedAsTheWaitOfTheOldestWarp) {
  for (const WarpWait wait :
       {WarpWait::memory, WarpWait::checkpoint, WarpWait::stack, WarpWait::unit, WarpWait::any_hit, WarpWait::retire}) {
    EXPECT_EQ(name_of(stall_of(wait)), name_of(wait));
  }
}

}  // namespace
}  // namespace grtx::modules
