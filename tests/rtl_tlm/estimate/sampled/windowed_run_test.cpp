// Sampled mode by windows, on a random trace that is large for a small machine.
#include "grtx/rtl_tlm/estimate/sampled/windowed_run.h"

#include <gtest/gtest.h>

#include "grtx/base/error.h"
#include "grtx/rtl_tlm/estimate/sampled/window_plan.h"
#include "rtl_tlm/estimate/sampled/random_trace_run.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

class WindowedRunTest : public test::RandomTraceRun {
 protected:
  static constexpr unsigned kGroups = 2400;

  explicit WindowedRunTest(unsigned secondary = 0) : RandomTraceRun(11, kGroups, secondary) {
    config_.resident_warps = 8 / config_.sms;
  }
  static SampledOptions windows(std::uint64_t seed = 1) {
    SampledOptions options;
    options.price = describe_energy;
    options.model = SampleModel::windows;
    options.seed = seed;
    return options;
  }
};

TEST_F(WindowedRunTest, EstimatesTheRunAndCoversIt) {
  const ordered_json full = cycle_mode().at("stats");
  const double truth = full.at("gpu.cycles").at("value").get<double>();
  unsigned covered = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const SampledResult sampled = simulate_sampled(file_.path(), config_, windows(seed));
    ASSERT_FALSE(sampled.estimate.whole);
    EXPECT_TRUE(sampled.result.violations.empty());
    EXPECT_NEAR(sampled.cycles.value / truth, 1.0, 0.1) << seed;
    covered += sampled.cycles.low <= truth && truth <= sampled.cycles.high ? 1U : 0U;
    const ordered_json& stats = sampled.result.document.at("stats");
    const auto value = [&stats](const char* name) { return stats.at(name).at("value").get<double>(); };
    EXPECT_EQ(stats.at("gpu.rt.node_visits"), full.at("gpu.rt.node_visits"));
    EXPECT_EQ(stats.at("gpu.bound.longest_warp").at("value"), full.at("gpu.bound.longest_warp").at("value"));
    EXPECT_NEAR(value("gpu.l2.accesses") / full.at("gpu.l2.accesses").at("value").get<double>(), 1.0, 0.2);
    EXPECT_NEAR(value("gpu.energy_nj") / full.at("gpu.energy_nj").at("value").get<double>(), 1.0, 0.2);
    EXPECT_NEAR(value("gpu.sampled.share"), 0.1, 0.02);
    EXPECT_GE(value("gpu.sampled.windows"), kFewestWindows);
    EXPECT_EQ(value("gpu.sampled.samples"), 1);
    EXPECT_EQ(sampled.result.inputs.at("sampled.model"), "windows");
    EXPECT_EQ(sampled.result.inputs.at("sampled.share"), "0.1");
  }
  EXPECT_GE(covered, 3U);
}

TEST_F(WindowedRunTest, GivesTheSameEachTimeWhateverRunsBesideIt) {
  SampledOptions options = windows();
  const ordered_json first = simulate_sampled(file_.path(), config_, options).result.document;
  options.jobs = 2;
  const ordered_json second = simulate_sampled(file_.path(), config_, options).result.document;
  EXPECT_EQ(first.at("sampled"), second.at("sampled"));
  EXPECT_EQ(first.at("stats").at("gpu.cycles"), second.at("stats").at("gpu.cycles"));
  EXPECT_EQ(first.at("inputs"), second.at("inputs"));
}

TEST_F(WindowedRunTest, FastModeRunsTheSameWindows) {
  SampledOptions options = windows();
  const SampledResult cycle = simulate_sampled(file_.path(), config_, options);
  options.engine = SimulationMode::fast;
  const SampledResult fast = simulate_sampled(file_.path(), config_, options);
  ASSERT_EQ(cycle.estimate.evidence.size(), fast.estimate.evidence.size());
  for (std::size_t i = 0; i < cycle.estimate.evidence.size(); ++i) {
    EXPECT_EQ(cycle.estimate.evidence[i].group, fast.estimate.evidence[i].group);
  }
  EXPECT_NEAR(fast.cycles.value / cycle.cycles.value, 1.0, 0.1);
  EXPECT_GT(fast.estimate.bias.cycles, cycle.estimate.bias.cycles);
}

TEST_F(WindowedRunTest, WhatFastModeLacksIsRefusedByItAndRunsInCycleMode) {
  config_.rt.memory.by_shader = true;
  SampledOptions options = windows();
  EXPECT_EQ(simulate_sampled(file_.path(), config_, options).result.inputs.at("sampled.model"), "windows");
  options.engine = SimulationMode::fast;
  EXPECT_THROW(simulate_sampled(file_.path(), config_, options), Error);
}

TEST_F(WindowedRunTest, TracesTooSmallForWindowsAreModelledByVisits) {
  config_.resident_warps = 64;
  EXPECT_EQ(simulate_sampled(file_.path(), config_, windows()).result.inputs.at("sampled.model"), "visits");
}

class WindowedRunOfTwoLaunches : public WindowedRunTest {
 protected:
  WindowedRunOfTwoLaunches() : WindowedRunTest(kGroups / 4) {}
};

TEST_F(WindowedRunOfTwoLaunches, IsModelledByVisits) {
  EXPECT_EQ(simulate_sampled(file_.path(), config_, windows()).result.inputs.at("sampled.model"), "visits");
}

TEST_F(WindowedRunTest, TargetsBelowTheBiasAreNotTriedWithWindows) {
  SampledOptions options = windows();
  options.target_error = 2.0 * kWindowsBias.cycles;
  const SampledResult sampled = simulate_sampled(file_.path(), config_, options);
  EXPECT_TRUE(sampled.estimate.whole);
  EXPECT_NE(sampled.result.document.dump().find("below what windows leave over"), std::string::npos);
}

TEST_F(WindowedRunTest, TargetsAskForMoreWindowsAndInTheEndForAll) {
  SampledOptions options = windows();
  options.target_error = 0.5;
  const SampledResult loose = simulate_sampled(file_.path(), config_, options);
  EXPECT_FALSE(loose.estimate.whole);
  EXPECT_LE(loose.cycles.half_width, 0.5);
  options.target_error = 0.8 * loose.cycles.half_width;
  const SampledResult closer = simulate_sampled(file_.path(), config_, options);
  EXPECT_FALSE(closer.estimate.whole);
  EXPECT_LE(closer.cycles.half_width, options.target_error);
  EXPECT_EQ(closer.result.inputs.at("sampled.share"), "0.1");  // as asked for
  EXPECT_GT(closer.estimate.evidence.size(), loose.estimate.evidence.size());
  options.target_error = 1e-4;
  const SampledResult tight = simulate_sampled(file_.path(), config_, options);
  EXPECT_TRUE(tight.estimate.whole);
  EXPECT_EQ(tight.result.document.at("stats").at("gpu.cycles"), cycle_mode().at("stats").at("gpu.cycles"));
}

}  // namespace
}  // namespace grtx::sim
