// SPDX-License-Identifier: Apache-2.0
// The estimate from windows, against closed forms: a machine that runs one group after the other.
#include "grtx/rtl_tlm/estimate/windows/window_estimate.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

namespace grtx::sim {
namespace {

constexpr std::array<double, kCosts> kRates = {0.3, 0.2, 5.0};

/// Costs that differ from group to group, no two in proportion.
std::vector<GroupCosts> some_costs(std::size_t groups) {
  std::vector<GroupCosts> costs(groups);
  for (std::size_t i = 0; i < groups; ++i) {
    costs[i][0] = 1000.0 + static_cast<double>(i * i % 997);
    costs[i][1] = 500.0 + static_cast<double>(i * 7 % 401);
    costs[i][2] = 20.0 + static_cast<double>(i * i * i % 31);
  }
  return costs;
}

double cycles_of(const GroupCosts& costs) { return kRates[0] * costs[0] + kRates[1] * costs[1] + kRates[2] * costs[2]; }

/// The groups of the windows one after the other, each `factor` times its costs' cycles.
GroupTimes in_turn(const std::vector<Window>& windows, const std::vector<GroupCosts>& costs,
                   const std::vector<double>& factor) {
  GroupTimes times;
  double now = 0.0;
  for (const std::uint64_t i : groups_of(windows)) {
    times.launched.push_back(now);
    now += factor[i] * cycles_of(costs[i]);
    times.ended.push_back(now);
  }
  return times;
}

double whole(const std::vector<GroupCosts>& costs, const std::vector<double>& factor) {
  double cycles = 0.0;
  for (std::size_t i = 0; i < costs.size(); ++i) cycles += factor[i] * cycles_of(costs[i]);
  return cycles;
}

constexpr std::uint64_t kSlots = 32;  // windows of 128 groups, of which 96 are measured

TEST(WindowEstimate, CostsAreMetEvenlyFromLaunchToEnd) {
  const GroupTimes times{{0.0, 10.0, 10.0}, {20.0, 30.0, 10.0}};
  std::vector<GroupCosts> costs(3);
  costs[0][0] = 100.0;
  costs[1][0] = 40.0;
  costs[2][1] = 7.0;
  EXPECT_DOUBLE_EQ(costs_between(times, costs, 0.0, 10.0)[0], 50.0);
  EXPECT_DOUBLE_EQ(costs_between(times, costs, 10.0, 20.0)[0], 50.0 + 20.0);
  EXPECT_DOUBLE_EQ(costs_between(times, costs, 10.0, 20.0)[1], 7.0);
  EXPECT_DOUBLE_EQ(costs_between(times, costs, 0.0, 100.0)[0], 140.0);
}

TEST(WindowEstimate, RatesAreFoundWhereCostsExplainAllCycles) {
  std::vector<CostRow> rows;
  for (const GroupCosts& costs : some_costs(40)) rows.push_back({cycles_of(costs), costs});
  const auto rates = fit_costs(rows);
  for (std::size_t c = 0; c < kCosts; ++c) EXPECT_NEAR(rates[c] / kRates[c], 1.0, 1e-3) << c;
}

TEST(WindowEstimate, NoRateIsNegativeAndCostsThatNobodyHasAreFree) {
  std::vector<CostRow> rows;
  for (std::size_t i = 0; i < 20; ++i) {
    GroupCosts costs;
    costs[0] = 100.0 + static_cast<double>(i * i % 17);
    costs[1] = 300.0 - static_cast<double>(i * i % 17);
    rows.push_back({2.0 * costs[0] - 0.1 * costs[1], costs});
  }
  const auto rates = fit_costs(rows);
  EXPECT_GT(rates[0], 0.0);
  EXPECT_EQ(rates[1], 0.0);
  EXPECT_EQ(rates[2], 0.0);
}

TEST(WindowEstimate, CostsThatExplainAllGiveTheWholeRun) {
  const std::vector<GroupCosts> costs = some_costs(16000);
  const std::vector<double> factor(costs.size(), 1.0);
  const std::vector<Window> windows = plan_windows(costs.size(), kSlots, 0.2, 7);
  const WindowEstimate estimate = estimate_windows(in_turn(windows, costs, factor), windows, costs);
  EXPECT_NEAR(estimate.cycles / whole(costs, factor), 1.0, 1e-3);
  for (const GroupEvidence& e : estimate.evidence) EXPECT_NEAR(e.residual, 0.0, 1e-3);
}

TEST(WindowEstimate, TheStartAndTheEndCountOnce) {
  const std::vector<GroupCosts> costs = some_costs(16000);
  std::vector<double> factor(costs.size(), 1.0);
  for (std::size_t i = 0; i < starting_groups(kSlots); ++i) factor[i] = 20.0;  // cold
  factor.back() = 100.0;
  const std::vector<Window> windows = plan_windows(costs.size(), kSlots, 0.2, 7);
  const WindowEstimate estimate = estimate_windows(in_turn(windows, costs, factor), windows, costs);
  EXPECT_NEAR(estimate.cycles / whole(costs, factor), 1.0, 1e-3);
}

TEST(WindowEstimate, WindowsThatStillSettleDrift) {
  const std::vector<GroupCosts> costs = some_costs(16000);
  std::vector<double> factor(costs.size(), 1.0);
  const std::vector<Window> windows = plan_windows(costs.size(), kSlots, 0.2, 7);
  for (const Window& w : windows) {
    for (std::uint64_t i = w.measured; i < w.measured + measured_groups(kSlots) / 2; ++i) factor[i] = 1.1;
  }
  const WindowEstimate estimate = estimate_windows(in_turn(windows, costs, factor), windows, costs);
  EXPECT_NEAR(estimate.drift, 0.05, 0.005);  // a tenth more in one half; the estimate is 5 % too high, too
}

TEST(WindowEstimate, FollowsWhatCostsDoNotExplainAlongTheTrace) {
  const std::vector<GroupCosts> costs = some_costs(32000);
  std::vector<double> factor(costs.size());
  for (std::size_t i = 0; i < factor.size(); ++i) factor[i] = 1.5 + std::sin(static_cast<double>(i) / 4000.0);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const std::vector<Window> windows = plan_windows(costs.size(), kSlots, 0.2, seed);
    const WindowEstimate estimate = estimate_windows(in_turn(windows, costs, factor), windows, costs);
    EXPECT_NEAR(estimate.cycles / whole(costs, factor), 1.0, 0.03) << seed;
  }
}

TEST(WindowEstimate, IntervalsOfRandomPacesCoverTheTruth) {
  const std::vector<GroupCosts> costs = some_costs(32000);
  std::vector<double> factor(costs.size());
  std::uint64_t state = 1;
  for (double& f : factor) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    f = 1.0 + 3.0 * static_cast<double>(state >> 40) / static_cast<double>(1 << 24);
  }
  unsigned covered = 0;
  constexpr unsigned kSeeds = 100;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const std::vector<Window> windows = plan_windows(costs.size(), kSlots, 0.1, seed);
    const WindowEstimate windowed = estimate_windows(in_turn(windows, costs, factor), windows, costs);
    CycleEstimate estimate;
    estimate.log_cycles = std::log(windowed.cycles);
    estimate.evidence = windowed.evidence;
    const ConfidenceInterval interval = cycles_interval(estimate);
    EXPECT_LT(interval.half_width, 0.2);
    covered += interval.low <= whole(costs, factor) && whole(costs, factor) <= interval.high ? 1U : 0U;
  }
  EXPECT_GE(covered, kSeeds * 88 / 100);
}

}  // namespace
}  // namespace grtx::sim
