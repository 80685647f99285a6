// SPDX-License-Identifier: Apache-2.0
// Which warp calls the any-hit shader, and from which cycle on.
#include "grtx/modules/rt_unit/any_hit_collector/decide/any_hit_firing.h"

#include <gtest/gtest.h>

#include <optional>

namespace grtx::modules {
namespace {

constexpr Cycle kTimeout = 10;

class AnyHitFires : public ::testing::Test {
 protected:
  // A warp whose lanes `lanes` are in the round; `hits` of them wait for the shader since cycle `since`.
  void warp(unsigned entry, LaneMask lanes, LaneMask hits, Cycle since) {
    Warp& warp = warps.warp(entry);
    warp.lanes = lanes;
    warp.in[static_cast<std::size_t>(LaneState::waiting_any_hit)] = hits;
    warp.in[static_cast<std::size_t>(LaneState::waiting_memory)] = lanes & ~hits;
    warp.any_hit_since = since;
  }

  WarpTable warps{4};
  AnyHitFiring firing{kTimeout};
};

TEST_F(AnyHitFires, AtOnceWhenEachActiveLaneHasAHit) {
  warp(0, 0b111, 0b111, 100);
  EXPECT_EQ(firing.due(warps.warp(0)), 0u);
  EXPECT_EQ(firing.next(warps, 0b1, 100), 0u);
}

TEST_F(AnyHitFires, ATimeoutAfterItsFirstHitWhenALaneHasNone) {
  warp(0, 0b111, 0b011, 100);
  EXPECT_EQ(firing.due(warps.warp(0)), 100 + kTimeout);
  EXPECT_EQ(firing.next(warps, 0b1, 100 + kTimeout - 1), std::nullopt);
  EXPECT_EQ(firing.next(warps, 0b1, 100 + kTimeout), 0u);
}

TEST_F(AnyHitFires, WithoutWaitingForLanesThatHaveFinished) {
  warp(0, 0b111, 0b011, 100);
  warps.warp(0).in[static_cast<std::size_t>(LaneState::finished)] = 0b100;
  EXPECT_EQ(firing.due(warps.warp(0)), 0u);
}

TEST_F(AnyHitFires, TheOldestOfTheWarpsThatAreDue) {
  // Accepted in the order of their entries, so that a lower one is older.
  traces::RayGroup group;
  group.rays.resize(1);
  group.rays[0].rounds.resize(1);
  TraceCall call;
  call.group = &group;
  for (std::uint16_t slot = 0; slot < 3; ++slot) {
    call.slot = slot;
    warps.accept(0, call);
  }
  warp(0, 0b11, 0b01, 100);  // older, but due only at 110
  warp(1, 0b11, 0b11, 105);
  warp(2, 0b11, 0b11, 90);
  EXPECT_EQ(firing.next(warps, 0b111, 105), 1u);
  EXPECT_EQ(firing.next(warps, 0b101, 105), 2u) << "a warp with a batch at the shader is no candidate";
  EXPECT_EQ(firing.next(warps, 0b111, 110), 0u);
}

TEST_F(AnyHitFires, NextInTheEarliestCycleOfAll) {
  EXPECT_EQ(firing.earliest(warps, 0, 100), kNever);
  warp(0, 0b11, 0b01, 100);
  warp(1, 0b11, 0b01, 97);
  EXPECT_EQ(firing.earliest(warps, 0b11, 101), 97 + kTimeout);
  EXPECT_EQ(firing.earliest(warps, 0b11, 120), 121u) << "one that is due already goes in the next cycle";
}

}  // namespace
}  // namespace grtx::modules
