// SPDX-License-Identifier: Apache-2.0
// Windows: one in each stratum, the last at the trace's end, the same for every design.
#include "grtx/rtl_tlm/estimate/windows/window_plan.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace grtx::sim {
namespace {

constexpr std::uint64_t kWarpSlots = 64;
const std::uint64_t kStart = starting_groups(kWarpSlots);
const std::uint64_t kLength = settling_groups(kWarpSlots) + measured_groups(kWarpSlots);

TEST(WindowPlan, StrataAreTheTraceAndEachHasItsWindow) {
  for (const std::uint64_t groups : {12000U, 12001U, 36464U}) {
    const std::vector<Window> windows = plan_windows(groups, kWarpSlots, 0.25, 3);
    ASSERT_EQ(windows.size(), groups / 4 / kLength);
    std::uint64_t next = kStart;
    for (const Window& w : windows) {
      EXPECT_EQ(w.stratum_first, next);
      EXPECT_LE(w.stratum_first, w.measured);
      EXPECT_EQ(w.measured - w.first, &w == &windows.front() ? kStart : settling_groups(kWarpSlots));
      EXPECT_EQ(w.end - w.measured, measured_groups(kWarpSlots));
      EXPECT_LE(w.end, w.stratum_end);
      next = w.stratum_end;
    }
    EXPECT_EQ(next, groups);
    EXPECT_EQ(windows.back().end, groups);
    EXPECT_EQ(windows.front().first, 0U);
    EXPECT_EQ(windows.front().measured, windows.front().stratum_first);
    const std::vector<std::uint64_t> all = groups_of(windows);
    EXPECT_EQ(all.size(), windows.size() * kLength + kStart - settling_groups(kWarpSlots));
    EXPECT_TRUE(std::is_sorted(all.begin(), all.end()));
    EXPECT_EQ(std::adjacent_find(all.begin(), all.end()), all.end());
  }
}

TEST(WindowPlan, ThereIsNoneWhereWindowsAreTooFew) {
  const std::uint64_t enough = 2 * kFewestWindows * kLength;  // the fewest windows are half of it
  for (const double share : {0.01, 0.1, 0.5}) {
    EXPECT_EQ(plan_windows(enough, kWarpSlots, share, 1).size(), kFewestWindows);
    EXPECT_TRUE(plan_windows(enough - 1, kWarpSlots, share, 1).empty());
  }
  EXPECT_TRUE(plan_windows(512, 256, 0.1, 1).empty());  // 128 x 128 rays on 8 SMs
}

// With one SM of 8 slots a window was 4 groups, and 12 of 18 intervals missed; with 256 slots it was half of what is
// under way at a time.
TEST(WindowPlan, AWindowIsTwoWavesAndNoHandfulOfGroupsHoweverFewTheSlots) {
  for (const std::uint64_t slots : {1U, 8U, 32U, 64U}) {
    EXPECT_EQ(settling_groups(slots), 32U);
    EXPECT_EQ(measured_groups(slots), 96U);
    EXPECT_TRUE(plan_windows(640, slots, 0.5, 1).empty());
  }
  EXPECT_EQ(settling_groups(256) + measured_groups(256), 512U);
}

TEST(WindowPlan, SeedsDrawThePlacesOfAllButTheFirstAndTheLast) {
  const std::vector<Window> one = plan_windows(30000, kWarpSlots, 0.1, 1),
                            same = plan_windows(30000, kWarpSlots, 0.1, 1),
                            other = plan_windows(30000, kWarpSlots, 0.1, 2);
  EXPECT_EQ(groups_of(one), groups_of(same));
  ASSERT_EQ(one.size(), other.size());
  std::size_t moved = 0;
  for (std::size_t i = 0; i < one.size(); ++i) moved += one[i].first != other[i].first ? 1U : 0U;
  EXPECT_GE(moved, one.size() / 2);
  EXPECT_EQ(one.back().first, other.back().first);
}

TEST(WindowPlan, WindowsAreAnywhereInTheirStrata) {
  double place = 0.0;
  constexpr unsigned kSeeds = 200;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const Window w = plan_windows(30000, kWarpSlots, 0.1, seed)[1];
    place += static_cast<double>(w.first - w.stratum_first) /
             static_cast<double>(w.stratum_end - w.stratum_first - kLength) / kSeeds;
  }
  EXPECT_NEAR(place, 0.5, 0.1);  // its deviation is 0.02
}

}  // namespace
}  // namespace grtx::sim
