// SPDX-License-Identifier: Apache-2.0
// Statistics of an estimate, each by its kind: where the windows are the whole trace, those of cycle mode; else exact,
// with an interval, or absent.
#include "grtx/rtl_tlm/estimate/windows/scaled_statistics.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"
#include "grtx/rtl_tlm/run/statistics_reference.h"
#include "rtl_tlm/estimate/windows/random_trace_run.h"

namespace grtx::sim {
namespace {

using modules::Statistic;
using modules::StatisticKind;
using nlohmann::ordered_json;

class ScaledStatistics : public test::RandomTraceRun {
 protected:
  static constexpr unsigned kGroups = 10560;  // 24 windows of 440

  ScaledStatistics() : RandomTraceRun(11, kGroups) { config_.resident_warps = 8 / config_.sms; }

  /// The whole run as estimated from windows that leave no group out. more: statistics that the run has besides.
  WholeStatistics of_windows_that_cover_everything(const std::vector<Statistic>& more = {}) const {
    std::vector<Window> windows;
    constexpr std::uint64_t kLength = kGroups / 24;
    for (std::uint64_t first = 0; first < kGroups; first += kLength) {
      windows.push_back({first, first + kLength, first + kLength / 4, first, first + kLength});
    }
    const traces::Reader reader(file_.path());
    GroupRun run;
    run.groups = groups_of(windows);
    run.read_at = launches_to_read(windows);
    const auto child = start_group_run(file_.path(), config_, run);
    finish_group_run(*child, run);
    EXPECT_TRUE(run.violations.empty());
    for (const Statistic& s : more) run.statistics.add(s);
    const std::vector<GroupCosts> costs(run.work.begin(), run.work.end());
    WholeRun whole;
    whole.cycles.value = whole.cycles.low = whole.cycles.high = run.cycles;
    whole.groups = kGroups;
    whole.totals = reader.totals();
    return whole_statistics(run, windows, costs, whole);
  }

  void expect_those_of_cycle_mode() const {
    const WholeStatistics estimated = of_windows_that_cover_everything();
    const ordered_json full = cycle_mode().at("stats");
    std::map<StatisticKind, unsigned> kinds;
    for (const Statistic& s : estimated.list.items()) {
      ASSERT_TRUE(full.contains(s.name)) << s.name;
      if (s.name == "gpu.bound.largest" || s.name == "gpu.bound.fraction") continue;  // of those that are known
      EXPECT_DOUBLE_EQ(s.number(), full.at(s.name).at("value").get<double>()) << s.name << ", " << name_of(s.kind);
      ++kinds[s.kind];
    }
    for (const StatisticKind kind : {StatisticKind::count, StatisticKind::exact, StatisticKind::mean,
                                     StatisticKind::share, StatisticKind::histogram, StatisticKind::bound}) {
      EXPECT_GT(kinds[kind], 4U) << name_of(kind);
    }
    EXPECT_GT(kinds[StatisticKind::ratio], 0U);
  }
  static bool follows_from_misses(const std::string& name) {
    for (const char* prefix :
         {"gpu.l1.", "gpu.l2.", "gpu.crossbar.", "gpu.dram.", "gpu.energy_nj.l2", "gpu.energy_nj.crossbar",
          "gpu.energy_nj.dram", "gpu.rt.node_fetch_latency", "gpu.rt.stall.", "gpu.rt.warp_cycles.",
          "gpu.rt.ray_box.queue_cycles", "gpu.simt.warp_cycles.memory", "gpu.simt.lsu.blocked_cycles",
          "gpu.bound.l1_miss_port", "gpu.bound.l2_port", "gpu.bound.dram_bandwidth"}) {
      if (name.starts_with(prefix)) return true;
    }
    return false;
  }
};

TEST_F(ScaledStatistics, WindowsThatCoverEverythingGiveThoseOfCycleMode) { expect_those_of_cycle_mode(); }

// With heaps no shader is called: an estimate said that it was called for each hit of the trace.
TEST_F(ScaledStatistics, CallsOfAShaderThatHeapsReplaceAreNone) {
  config_.rt.any_hit_unit.enabled = true;
  expect_those_of_cycle_mode();
}

// The mean was over the cycles of SMs, not of RT units: with two of them it was twice as high.
TEST_F(ScaledStatistics, OccupancyIsOfAnRtUnit) {
  config_.rt_units = 2;
  expect_those_of_cycle_mode();
}

// An exact statistic that no total of the trace gave was absent from estimates, and nobody was told.
TEST_F(ScaledStatistics, AnExactOneThatNoTotalGivesIsAFaultOfTheModel) {
  Statistic unknown;
  unknown.name = "gpu.rt.new_events";
  unknown.value = std::uint64_t{1};
  unknown.kind = StatisticKind::exact;
  EXPECT_THROW(of_windows_that_cover_everything({unknown}), std::logic_error);
  unknown.kind = StatisticKind::state;
  EXPECT_NO_THROW(of_windows_that_cover_everything({unknown}));
}

TEST_F(ScaledStatistics, EachIsExactOrHasAnIntervalOrIsAbsent) {
  const ordered_json full = cycle_mode().at("stats");
  unsigned intervals = 0, held = 0, exact = 0;
  std::set<std::string> missed;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const EstimatedResult estimated =
        simulate_windows(file_.path(), config_, {.share = 0.25, .seed = seed, .price = explore::describe_energy});
    ASSERT_FALSE(estimated.estimate.whole);
    const ordered_json& written = estimated.result.document.at("windows").at("intervals");
    std::set<std::string> names;
    for (const Statistic& s : estimated.result.statistics.items()) {
      if (s.name.starts_with("gpu.windows.")) continue;  // of the estimate itself
      ASSERT_TRUE(full.contains(s.name)) << s.name;
      names.insert(s.name);
      // The DRAM's traffic was 2 to 3 times what it is where the L2 holds the scene.
      EXPECT_FALSE(follows_from_misses(s.name)) << s.name;
      const double truth = full.at(s.name).at("value").get<double>();
      if (s.kind == StatisticKind::largest || s.kind == StatisticKind::smallest || s.kind == StatisticKind::state) {
        EXPECT_TRUE(s.name == "gpu.cycles" || s.name == "gpu.time_us") << s.name << ": windows may miss the largest";
      }
      const auto interval = estimated.intervals.find(s.name);
      if (interval == estimated.intervals.end()) {
        EXPECT_EQ(s.number(), truth) << s.name << " has no interval, so it is exact";
        ++exact;
        continue;
      }
      const auto& [low, high] = interval->second;
      EXPECT_LE(low, s.number() * (1 + 1e-9) + 0.5) << s.name;
      EXPECT_GE(high, s.number() * (1 - 1e-9) - 0.5) << s.name;
      EXPECT_EQ(written.at(s.name), ordered_json({low, high})) << s.name;
      ++intervals;
      if (low <= truth && truth <= high) {
        ++held;
      } else {
        missed.insert(s.name);
      }
    }
    for (const auto& [name, entry] : full.items()) {
      if (name.starts_with("host.") || names.contains(name) || follows_from_misses(name)) continue;
      const Statistic* const declared = declared_statistic(name);
      ASSERT_NE(declared, nullptr) << name;
      // A bin that the windows did not reach is absent, too.
      const StatisticKind kind = declared->kind;
      const bool left_out = kind == StatisticKind::largest || kind == StatisticKind::smallest ||
                            kind == StatisticKind::state || kind == StatisticKind::histogram || is_of_one_part(name) ||
                            name.starts_with("gpu.bound.longest_");
      const bool of_nothing =
          kind == StatisticKind::mean || kind == StatisticKind::ratio || kind == StatisticKind::share;
      EXPECT_TRUE(left_out || (of_nothing && entry.at("value") == 0.0)) << name << " is absent";
    }
  }
  EXPECT_GE(exact, 4U * 12U);
  EXPECT_GE(intervals, 4U * 80U);
  EXPECT_GE(held, intervals * 9 / 10) << held << " of " << intervals
                                      << ", missed: " << ::testing::PrintToString(missed);
}

}  // namespace
}  // namespace grtx::sim
