// Sampled mode as a whole, on random traces: exact at the whole trace, deterministic, honest about its error.
#include "grtx/rtl_tlm/estimate/sampled/sampled_simulation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>

#include "grtx/base/error.h"
#include "paths.h"
#include "rtl_tlm/estimate/sampled/random_trace_run.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

class SampledSimulation : public test::RandomTraceRun {
 protected:
  static constexpr unsigned kGroups = 160;

  SampledSimulation() : RandomTraceRun(5, kGroups) {}

  static ordered_json without_host(const ordered_json& stats) {
    ordered_json rest;
    for (const auto& [name, entry] : stats.items()) {
      if (!name.starts_with("host.")) rest[name] = entry;
    }
    return rest;
  }
  static SampledOptions share(double share, std::uint64_t seed = 1) {
    SampledOptions options;
    options.price = describe_energy;
    options.share = share;
    options.seed = seed;
    return options;
  }
};

TEST_F(SampledSimulation, TheWholeTraceIsTheFullRun) {
  const SampledResult sampled = simulate_sampled(file_.path(), config_, share(1.0));
  const ordered_json full = cycle_mode().at("stats");
  const ordered_json& stats = sampled.result.document.at("stats");
  for (const auto& [name, entry] : full.items()) {
    if (name.starts_with("host.")) continue;
    EXPECT_EQ(stats.at(name), entry) << name;
  }
  EXPECT_EQ(stats.at("gpu.sampled.share").at("value"), 1.0);
  EXPECT_EQ(stats.at("gpu.sampled.half_width").at("value"), 0.0);
  EXPECT_EQ(sampled.cycles.low, full.at("gpu.cycles").at("value").get<double>());
  EXPECT_EQ(sampled.cycles.high, sampled.cycles.low);
}

TEST_F(SampledSimulation, GivesTheSameEachTimeWhateverRunsBesideIt) {
  SampledOptions options = share(0.0625);
  const ordered_json first = simulate_sampled(file_.path(), config_, options).result.document;
  options.jobs = 2;
  const ordered_json second = simulate_sampled(file_.path(), config_, options).result.document;
  EXPECT_EQ(without_host(first.at("stats")), without_host(second.at("stats")));
  EXPECT_EQ(first.at("sampled"), second.at("sampled"));
  EXPECT_EQ(first.at("inputs"), second.at("inputs"));
  EXPECT_FALSE(first.at("sampled").at("whole").get<bool>());
}

TEST_F(SampledSimulation, NamesWhatTheFullRunNames) {
  const SampledResult sampled = simulate_sampled(file_.path(), config_, share(0.0625));
  const ordered_json& stats = sampled.result.document.at("stats");
  const ordered_json full = cycle_mode().at("stats");
  for (const auto& [name, entry] : full.items()) {
    const bool of_one_part = name.starts_with("gpu.sm") || name.starts_with("gpu.dram.channel") ||
                             name.starts_with("gpu.distributor.") || name.starts_with("gpu.rays.");
    if (of_one_part || name == "host.ticks" || name.find(".histogram.") != name.npos) continue;
    if (name.starts_with("gpu.simt.")) continue;  // see below
    ASSERT_TRUE(stats.contains(name)) << name;
    EXPECT_EQ(stats.at(name).at("unit"), entry.at("unit")) << name;
  }
  EXPECT_TRUE(stats.contains("gpu.simt.instructions.total"));
  for (const char* exact : {"gpu.rt.node_visits", "gpu.rt.visits_leaf", "gpu.rt.any_hit_calls", "gpu.simt.warps",
                            "gpu.bound.longest_warp"}) {
    EXPECT_EQ(stats.at(exact).at("value"), full.at(exact).at("value")) << exact;
  }
  for (const char* name : {"share", "groups", "samples", "confidence", "cycles_low", "cycles_high", "half_width",
                           "deviation", "bias", "residual"}) {
    EXPECT_TRUE(stats.contains(std::string("gpu.sampled.") + name)) << name;
  }
  EXPECT_EQ(stats.at("gpu.sampled.groups").at("value"), kGroups / 16);
  EXPECT_TRUE(sampled.result.violations.empty());
  EXPECT_EQ(sampled.result.document.at("inputs").at("mode"), "sampled");
}

TEST_F(SampledSimulation, IntervalsCoverTheTruth) {
  const double truth = cycle_mode().at("stats").at("gpu.cycles").at("value").get<double>();
  unsigned covered = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const SampledResult sampled = simulate_sampled(file_.path(), config_, share(0.125, seed));
    ASSERT_FALSE(sampled.estimate.whole);
    EXPECT_NEAR(sampled.cycles.value / truth, 1.0, 0.3) << seed;
    covered += sampled.cycles.low <= truth && truth <= sampled.cycles.high ? 1U : 0U;
  }
  EXPECT_GE(covered, 5U);
}

TEST_F(SampledSimulation, TakesTheWarpModelForWhatFastModeLacks) {
  const auto model = [&] {
    return simulate_sampled(file_.path(), config_, share(0.25)).result.inputs.at("sampled.model");
  };
  EXPECT_EQ(model(), "visits");
  config_.rt.memory.by_shader = true;
  EXPECT_EQ(model(), "calls");
}

TEST_F(SampledSimulation, FastEngineTakesTheSameGroups) {
  SampledOptions options = share(0.0625);
  const SampledResult cycle = simulate_sampled(file_.path(), config_, options);
  options.engine = SimulationMode::fast;
  const SampledResult fast = simulate_sampled(file_.path(), config_, options);
  ASSERT_EQ(cycle.estimate.evidence.size(), fast.estimate.evidence.size());
  for (std::size_t i = 0; i < cycle.estimate.evidence.size(); ++i) {
    EXPECT_EQ(cycle.estimate.evidence[i].group, fast.estimate.evidence[i].group);
  }
  EXPECT_NEAR(fast.cycles.value / cycle.cycles.value, 1.0, 0.15);
}

TEST_F(SampledSimulation, GoesOnToTheWholeTraceWhenTheTargetIsTighter) {
  SampledOptions options = share(0.25);
  options.target_error = 0.001;
  const SampledResult sampled = simulate_sampled(file_.path(), config_, options);
  EXPECT_TRUE(sampled.estimate.whole);
  EXPECT_EQ(sampled.result.document.at("stats").at("gpu.cycles"), cycle_mode().at("stats").at("gpu.cycles"));
  EXPECT_NE(sampled.result.document.dump().find("to reach --target-error"), std::string::npos);
  options.target_error = 0.9;
  EXPECT_FALSE(simulate_sampled(file_.path(), config_, options).estimate.whole);
}

TEST_F(SampledSimulation, RefusesSharesAndTargetsOutOfRange) {
  for (const double bad : {0.0, -0.5, 1.5, std::nan("")}) {
    EXPECT_THROW(simulate_sampled(file_.path(), config_, share(bad)), Error) << bad;
  }
  SampledOptions options;
  options.target_error = 1.0;
  EXPECT_THROW(simulate_sampled(file_.path(), config_, options), Error);
}

/// Exit code and text of a command line of `grtx sim`.
std::pair<int, std::string> command(const std::string& arguments) {
  std::FILE* pipe = ::popen((grtx::paths::program() + " sim " + arguments + " 2>&1").c_str(), "r");
  std::string text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  return {WEXITSTATUS(::pclose(pipe)), text};
}

TEST_F(SampledSimulation, CommandLineRefusesInOneLine) {
  const struct {
    const char* arguments;
    const char* says;
  } rows[] = {{"--mode sampled --vcd w.vcd", "--mode cycle"},
              {"--mode sampled --timeline t.json", "--mode cycle"},
              {"--mode sampled --heatmap cycles=h.png", "--mode cycle"},
              {"--mode sampled --share 0", "--share"},
              {"--mode sampled --share 1.01", "--share"},
              {"--mode sampled --target-error 2%%", "--target-error"},
              {"--mode sampled --target-error none", "--target-error"},
              {"--mode sampled --target-error 150%", "--target-error"},
              {"--mode fast --share 0.1", "needs --mode sampled"},
              {"--seed 2", "needs --mode sampled"}};
  for (const auto& row : rows) {
    const auto [code, text] = command("'" + file_.path() + "' " + row.arguments);
    EXPECT_EQ(code, 2) << row.arguments;
    EXPECT_NE(text.find(row.says), std::string::npos) << row.arguments << ": " << text;
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
  }
}

}  // namespace
}  // namespace grtx::sim
