// SPDX-License-Identifier: Apache-2.0
// Windows mode, on a random trace that is large for a small machine: near cycle mode and honest about its error, exact
// where all is simulated.
#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "grtx/base/error.h"
#include "grtx/rtl_tlm/estimate/windows/window_plan.h"
#include "grtx/rtl_tlm/estimate/windows/window_refusal.h"
#include "paths.h"
#include "rtl_tlm/estimate/windows/random_trace_run.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

class WindowSimulation : public test::RandomTraceRun {
 protected:
  static constexpr unsigned kGroups = 10500;

  explicit WindowSimulation(unsigned secondary = 0) : RandomTraceRun(11, kGroups, secondary) {
    config_.resident_warps = 8 / config_.sms;
  }
  static WindowOptions windows(std::uint64_t seed = 1) {
    WindowOptions options{.share = 0.25, .seed = seed, .price = explore::describe_energy};
    return options;
  }
  static ordered_json without_host(const ordered_json& stats) {
    ordered_json rest;
    for (const auto& [name, entry] : stats.items()) {
      if (!name.starts_with("host.")) rest[name] = entry;
    }
    return rest;
  }
  /// What the whole trace gives in cycle mode, and a line that says why.
  void expect_whole(const WindowOptions& options, const std::string& why) const {
    ::testing::internal::CaptureStderr();
    const EstimatedResult estimated = simulate_windows(file_.path(), config_, options);
    const std::string said = ::testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find("all of it is simulated, in cycle mode: " + why), std::string::npos) << said;
    EXPECT_TRUE(estimated.estimate.whole);
    const ordered_json& stats = estimated.result.document.at("stats");
    const ordered_json full = without_host(cycle_mode().at("stats"));
    for (const auto& [name, entry] : full.items()) {
      EXPECT_EQ(stats.at(name), entry) << name;
    }
    EXPECT_EQ(stats.at("gpu.windows.share").at("value"), 1.0);
    EXPECT_NE(stats.at("gpu.windows.share").at("description").get<std::string>().find(why), std::string::npos);
    EXPECT_EQ(stats.at("gpu.windows.half_width").at("value"), 0.0);
    EXPECT_EQ(estimated.cycles.low, stats.at("gpu.cycles").at("value").get<double>());
    EXPECT_EQ(estimated.cycles.high, estimated.cycles.low);
  }
};

TEST_F(WindowSimulation, EstimatesTheRunAndCoversIt) {
  const ordered_json full = cycle_mode().at("stats");
  const double truth = full.at("gpu.cycles").at("value").get<double>();
  unsigned covered = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const EstimatedResult estimated = simulate_windows(file_.path(), config_, windows(seed));
    ASSERT_FALSE(estimated.estimate.whole);
    EXPECT_TRUE(estimated.result.violations.empty());
    EXPECT_NEAR(estimated.cycles.value / truth, 1.0, 0.1) << seed;
    covered += estimated.cycles.low <= truth && truth <= estimated.cycles.high ? 1U : 0U;
    const ordered_json& stats = estimated.result.document.at("stats");
    const auto value = [&stats](const char* name) { return stats.at(name).at("value").get<double>(); };
    EXPECT_EQ(stats.at("gpu.rt.node_visits"), full.at("gpu.rt.node_visits"));
    EXPECT_NEAR(value("gpu.rt.node_fetches") / full.at("gpu.rt.node_fetches").at("value").get<double>(), 1.0, 0.2);
    EXPECT_NEAR(value("gpu.energy_nj") / full.at("gpu.energy_nj").at("value").get<double>(), 1.0, 0.2);
    EXPECT_NEAR(value("gpu.windows.share"), 0.25, 0.02);
    EXPECT_GE(value("gpu.windows.count"), kFewestWindows);
    EXPECT_EQ(estimated.result.inputs.at("mode"), "windows");
    EXPECT_EQ(estimated.result.inputs.at("windows.share"), "0.25");
  }
  EXPECT_GE(covered, 3U);
}

// They were scaled: 5,356 calls of 5,400 warps.
TEST_F(WindowSimulation, FewerCallsThanWarps) {
  const ordered_json full = cycle_mode().at("stats");
  const ordered_json stats = simulate_windows(file_.path(), config_, windows()).result.document.at("stats");
  for (const char* calls : {"gpu.rt.calls", "gpu.simt.rounds"}) {
    EXPECT_EQ(stats.at(calls).at("value"), full.at(calls).at("value")) << calls;
  }
}

TEST_F(WindowSimulation, GivesTheSameEachTime) {
  const ordered_json first = simulate_windows(file_.path(), config_, windows()).result.document;
  const ordered_json second = simulate_windows(file_.path(), config_, windows()).result.document;
  EXPECT_EQ(first.at("windows"), second.at("windows"));
  EXPECT_EQ(without_host(first.at("stats")), without_host(second.at("stats")));
  EXPECT_EQ(first.at("inputs"), second.at("inputs"));
}

TEST_F(WindowSimulation, OfATraceTooSmallForWindowsAllIsSimulatedAndItSaysSo) {
  config_.sms = 8;
  config_.resident_warps = 32;
  expect_whole(windows(), "20 windows of 512 warps, the fewest, are more than half of 10500");
}

TEST_F(WindowSimulation, WindowsPayWhereTheySuitALargeTrace) {
  const traces::Reader reader(file_.path());
  const std::uint64_t visits = reader.totals().visits();
  EXPECT_TRUE(windows_pay(reader, config_, windows(), visits));
  EXPECT_FALSE(windows_pay(reader, config_, windows(), visits + 1));
  EXPECT_FALSE(windows_pay(reader, config_, windows()));  // by default: minutes of cycle mode
  config_.sms = 8;
  config_.resident_warps = 32;  // windows would be too few
  EXPECT_FALSE(windows_pay(reader, config_, windows(), 0));
}

class WindowSimulationOfTwoLaunches : public WindowSimulation {
 protected:
  WindowSimulationOfTwoLaunches() : WindowSimulation(kGroups / 4) {}
};

TEST_F(WindowSimulationOfTwoLaunches, AllIsSimulated) {
  EXPECT_FALSE(windows_pay(traces::Reader(file_.path()), config_, windows(), 0));
  expect_whole(windows(), "secondary rays are a second launch");
}

TEST_F(WindowSimulation, AShareOfMostIsTheWholeTrace) {
  WindowOptions options = windows();
  options.share = 1.0;
  expect_whole(options, "as asked for");
}

TEST_F(WindowSimulation, TargetsAskForMoreWindowsAndInTheEndForAll) {
  WindowOptions options = windows();
  options.target_error = 0.5;
  const EstimatedResult loose = simulate_windows(file_.path(), config_, options);
  EXPECT_FALSE(loose.estimate.whole);
  EXPECT_LE(loose.cycles.half_width, 0.5);
  options.target_error = 0.8 * loose.cycles.half_width;
  const EstimatedResult closer = simulate_windows(file_.path(), config_, options);
  EXPECT_FALSE(closer.estimate.whole);
  EXPECT_LE(closer.cycles.half_width, options.target_error);
  EXPECT_EQ(closer.result.inputs.at("windows.share"), "0.25");  // as asked for
  EXPECT_GT(closer.estimate.evidence.size(), loose.estimate.evidence.size());
}

TEST_F(WindowSimulation, SaysWhatTheTraceSaysAndHowFarItIsSure) {  // all others: scaled_statistics_test.cpp
  const EstimatedResult estimated = simulate_windows(file_.path(), config_, windows());
  const ordered_json& stats = estimated.result.document.at("stats");
  const ordered_json full = cycle_mode().at("stats");
  for (const char* exact :
       {"gpu.rt.node_visits", "gpu.rt.visits_leaf", "gpu.rt.any_hit_calls", "gpu.simt.warps", "gpu.simt.ray_rounds",
        "gpu.rt.checkpoint.entries_written", "gpu.rt.checkpoint.entries_read"}) {
    EXPECT_EQ(stats.at(exact).at("value"), full.at(exact).at("value")) << exact;
  }
  for (const char* name : {"share", "groups", "count", "confidence", "cycles_low", "cycles_high", "half_width",
                           "deviation", "drift", "residual"}) {
    EXPECT_TRUE(stats.contains(std::string("gpu.windows.") + name)) << name;
  }
  EXPECT_TRUE(estimated.result.violations.empty());
  EXPECT_EQ(estimated.result.document.at("inputs").at("mode"), "windows");
  EXPECT_EQ("largest lower bound: " + estimated.result.binding_bound, stats.at("gpu.bound.largest").at("description"));
}

TEST_F(WindowSimulation, RefusesSharesAndTargetsOutOfRange) {
  for (const double bad : {0.0, -0.5, 1.5, std::nan("")}) {
    WindowOptions options;
    options.share = bad;
    EXPECT_THROW(simulate_windows(file_.path(), config_, options), Error) << bad;
  }
  WindowOptions options;
  options.target_error = 1.0;
  EXPECT_THROW(simulate_windows(file_.path(), config_, options), Error);
}

/// Exit code and text of a command line of `grtx sim`.
std::pair<int, std::string> command(const std::string& arguments) {
  std::FILE* pipe = ::popen((grtx::paths::program() + " sim " + arguments + " 2>&1").c_str(), "r");
  std::string text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  return {WEXITSTATUS(::pclose(pipe)), text};
}

TEST_F(WindowSimulation, CommandLineRefusesInOneLine) {
  const struct {
    const char* arguments;
    const char* says;
  } rows[] = {{"--mode windows --vcd w.vcd", "--mode cycle"},
              {"--mode windows --timeline t.json", "--mode cycle"},
              {"--mode windows --heatmap cycles=h.png", "--mode cycle"},
              {"--mode windows --share 0", "--share"},
              {"--mode windows --share 1.01", "--share"},
              {"--mode windows --target-error 2%%", "--target-error"},
              {"--mode windows --target-error none", "--target-error"},
              {"--mode windows --target-error 150%", "--target-error"},
              {"--share 0.2", "needs --mode windows"},
              {"--target-error 2%", "needs --mode windows"},
              {"--seed 2", "needs --mode windows"},
              {"--mode model", "--mode: unknown value 'model', the nearest is 'cycle' (known: cycle, windows)"},
              {"--mode windows --sample-model visits", "--sample-model"}};
  for (const auto& row : rows) {
    const auto [code, text] = command("'" + file_.path() + "' " + row.arguments);
    EXPECT_EQ(code, 2) << row.arguments;
    EXPECT_NE(text.find(row.says), std::string::npos) << row.arguments << ": " << text;
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
  }
}

}  // namespace
}  // namespace grtx::sim
