// The warp model on cases that can be followed by hand, and its fit on runs that the model itself made.
#include "grtx/rtl_tlm/estimate/sampled/warp_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "grtx/rtl_tlm/estimate/sampled/model_fit.h"

namespace grtx::sim {
namespace {

constexpr double kStart = 100.0;  ///< cycles from launch to the first call

GroupWork group_of(const std::vector<std::vector<LaneWork>>& rounds) {
  GroupWork group;
  for (const auto& lanes : rounds) {
    group.rounds.push_back({lanes});
    for (const LaneWork& lane : lanes) {
      group.sectors += static_cast<double>(lane.sectors);
      group.far += static_cast<double>(lane.far);
    }
  }
  return group;
}

ModelRates rates(double step, double sm, double far, double memory) {
  ModelRates r;
  r.step_cycles = step;
  r.sm_sectors = sm;
  r.sm_far = far;
  r.memory_sectors = memory;
  r.round_cycles = 1000.0;
  return r;
}

double cycles(const std::vector<GroupWork>& groups, const ModelMachine& machine, const ModelRates& r) {
  std::vector<const GroupWork*> pointers;
  for (const GroupWork& group : groups) pointers.push_back(&group);
  return run_model(pointers, {}, machine, r).cycles;
}

TEST(WarpModel, IsBoundByLatencyPortAndMemoryInTurn) {
  // One lane of 50 steps, 2 sectors a step, all from memory.
  const std::vector<GroupWork> one = {group_of({{{50.0F, 100.0F, 100.0F}}})};
  const ModelMachine machine;
  const double between = kStart + 1000.0;
  EXPECT_NEAR(cycles(one, machine, rates(300, 1, 1, 1)), between + 50 * 300, 1.0);
  EXPECT_NEAR(cycles(one, machine, rates(1, 0.01, 1, 1)), between + 100 / 0.01, 1.0);
  EXPECT_NEAR(cycles(one, machine, rates(1, 1, 0.02, 1)), between + 100 / 0.02, 1.0);
  EXPECT_NEAR(cycles(one, machine, rates(1, 1, 1, 0.005)), between + 100 / 0.005, 1.0);
}

TEST(WarpModel, SharesThePortInsideAnSmAndTheMemoryBetweenSms) {
  const std::vector<GroupWork> two(2, group_of({{{50.0F, 100.0F, 100.0F}}}));
  ModelMachine one_sm, two_sms;
  one_sm.sms = 1;
  two_sms.sms = 2;
  const double between = kStart + 1000.0;
  EXPECT_NEAR(cycles(two, one_sm, rates(1, 0.01, 1, 1)), between + 200 / 0.01, 1.0);
  EXPECT_NEAR(cycles(two, two_sms, rates(1, 0.01, 1, 1)), between + 100 / 0.01, 1.0);
  EXPECT_NEAR(cycles(two, two_sms, rates(1, 1, 1, 0.01)), between + 200 / 0.01, 1.0);
  two_sms.memory_share = 0.5;
  EXPECT_NEAR(cycles(two, two_sms, rates(1, 1, 1, 0.01)), between + 400 / 0.01, 1.0);
}

TEST(WarpModel, CallsWaitForASlotAndRoundsFollowEachOther) {
  const std::vector<GroupWork> three(3, group_of({{{10.0F, 1.0F, 0.0F}}, {{20.0F, 1.0F, 0.0F}}}));
  ModelMachine machine;
  machine.sms = 1;
  machine.call_slots = 3;
  const ModelRates r = rates(100, 1, 1, 1);
  EXPECT_NEAR(cycles(three, machine, r), kStart + 1000 + 1000 + 1000 + 2000, 1.0);
  machine.call_slots = 1;  // 3 x 1000, then 3 x 2000 in the one slot; a round's gap of 1000 is hidden
  EXPECT_NEAR(cycles(three, machine, r), kStart + 3000 + 6000 + 1000, 1.0);
}

TEST(WarpModel, SecondaryGroupsWaitForThePrimaryOnes) {
  std::vector<GroupWork> groups(2, group_of({{{10.0F, 1.0F, 0.0F}}}));
  groups[1].kind = traces::RayKind::mirror;
  EXPECT_NEAR(cycles(groups, {}, rates(100, 1, 1, 1)), 2 * (kStart + 1000 + 1000), 1.0);
}

TEST(WarpModel, KnownLaunchesDecideTheSm) {
  const std::vector<GroupWork> groups(3, group_of({{{10.0F, 1.0F, 0.0F}}}));
  std::vector<const GroupWork*> pointers;
  for (const GroupWork& group : groups) pointers.push_back(&group);
  ModelMachine machine;
  machine.sms = 4;
  const ModelRun run = run_model(pointers, {{3, 0}, {3, 500}}, machine, rates(100, 1, 1, 1));
  EXPECT_EQ(run.group_sm, (std::vector<unsigned>{3, 3, 0}));
  EXPECT_NEAR(run.group_end[1] - run.group_end[0], 500.0, 1.0);
}

TEST(WarpModel, EmptyRunsAndGroupsWithoutRaysEnd) {
  EXPECT_EQ(run_model({}, {}, {}, {}).cycles, 0.0);
  const GroupWork nothing;
  EXPECT_LT(cycles({nothing, nothing}, {}, {}), 1000.0);
}

std::vector<GroupWork> random_groups(std::size_t count) {
  std::mt19937 random(7);
  const auto between = [&random](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967295.0;
  };
  std::vector<GroupWork> groups;
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<std::vector<LaneWork>> rounds(3);
    for (auto& lanes : rounds) {
      for (int l = 0; l < 32; ++l) {
        const auto steps = static_cast<float>(between(20, 400));
        lanes.push_back({steps, 2.0F * steps, static_cast<float>(between(0.8, 1.2)) * steps});
      }
      std::sort(lanes.begin(), lanes.end(), [](const LaneWork& a, const LaneWork& b) { return a.steps < b.steps; });
    }
    groups.push_back(group_of(rounds));
  }
  return groups;
}

TEST(ModelFit, FindsTheRatesOfRunsThatTheModelMade) {
  const std::vector<GroupWork> groups = random_groups(24);
  const ModelRates truth = rates(220, 0.7, 0.5, 2.0);
  std::vector<Observed> samples;
  for (const double share : {1.0 / 8, 1.0}) {
    Observed sample;
    for (std::size_t i = 0; i < 12; ++i) sample.groups.push_back(&groups[i + (share < 1.0 ? 0 : 12)]);
    sample.machine.sms = 1;
    sample.machine.memory_share = share;
    ModelRates made = truth;
    made.round_cycles = ModelRates{}.round_cycles;
    const ModelRun run = run_model(sample.groups, {}, sample.machine, made);
    sample.group_end = run.group_end;
    sample.cycles = run.cycles;
    samples.push_back(sample);
  }
  RatePrior prior;
  prior.mean = {std::log(300.0), std::log(0.85), std::log(0.6), std::log(2.5)};
  prior.deviation = {0.7, 0.3, 0.4, 0.5};
  const FittedRates fit = fit_rates(samples, prior);
  EXPECT_NEAR(rates_of(fit.log_rates).memory_sectors, 2.0, 0.04);
  EXPECT_LT(fit.residual, 0.02);
  std::vector<const GroupWork*> all;
  for (const GroupWork& group : groups) all.push_back(&group);
  ModelRates made = truth;
  made.round_cycles = ModelRates{}.round_cycles;
  const double whole = run_model(all, {}, {}, made).cycles;
  EXPECT_NEAR(std::exp(predict(all, {}, {}, fit.log_rates).value) / whole, 1.0, 0.03);
  EXPECT_EQ(fit_rates(samples, prior).log_rates, fit.log_rates) << "deterministic";
}

}  // namespace
}  // namespace grtx::sim
