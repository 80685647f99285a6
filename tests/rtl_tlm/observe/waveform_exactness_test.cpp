// SPDX-License-Identifier: Apache-2.0
// What a waveform shows is what the statistics count, to the cycle: busy pipelines, stall reasons, occupancy, warp
// activities, requests, checkpoint entries. Read back by a parser that shares no code with the writer.
#include <gtest/gtest.h>

#include <bit>
#include <cstdlib>

#include "grtx/base/atomic_file.h"
#include "grtx/modules/simt/decide/simt_core_config.h"
#include "grtx/rtl_tlm/observe/stall_follower.h"
#include "rtl_tlm/observe/observed_run.h"
#include "rtl_tlm/observe/vcd_reader.h"

namespace grtx::sim {
namespace {

using test::statistic;

constexpr std::uint64_t kPeriodFs = 732601;  // 1 / 1365 MHz
constexpr unsigned kSms = 2;

class WaveformExactness : public ::testing::TestWithParam<bool> {
 protected:
  VcdFile record(const CycleWindow& window = {}, const std::vector<std::string>& settings = {}) {
    SimulationOptions options;
    options.waveform.path = run_.path("w.vcd");
    options.waveform.window = window;
    stats_ = run_.run(options, settings);
    end_ = statistic(stats_, "gpu.cycles") * kPeriodFs;
    return read_vcd(read_file(options.waveform.path));
  }
  /// Sum over both SMs and all cycles before `to` of the signal's value.
  std::uint64_t sum(const VcdFile& file, const std::string& leaf, std::uint64_t to) const {
    std::uint64_t total = 0;
    for (unsigned sm = 0; sm < kSms; ++sm) {
      file.for_each_stretch("gpu.sm" + std::to_string(sm) + "." + leaf, 0, to,
                            [&](std::uint64_t value, std::uint64_t time) { total += value * (time / kPeriodFs); });
    }
    return total;
  }
  std::uint64_t last(const VcdFile& file, const std::string& leaf) const {
    std::uint64_t total = 0;
    for (unsigned sm = 0; sm < kSms; ++sm) {
      total += file.changes.at("gpu.sm" + std::to_string(sm) + "." + leaf).back().value;
    }
    return total;
  }
  bool checkpoint() const { return GetParam(); }

  test::ObservedRun run_{GetParam(), GetParam()};
  nlohmann::ordered_json stats_;
  std::uint64_t end_ = 0;  ///< of the run, fs
};

TEST_P(WaveformExactness, EveryCycleOfTheSchedulerIsAsCounted) {
  const VcdFile file = record();
  const std::vector<std::string> names = StallFollower::names();
  std::vector<std::uint64_t> cycles(names.size());
  for (unsigned sm = 0; sm < kSms; ++sm) {
    const std::string scope = "gpu.sm" + std::to_string(sm) + ".rt.rt_scheduler.";
    std::uint64_t issued = 0;
    file.for_each_stretch(scope + "stall_reason", 0, end_, [&](std::uint64_t value, std::uint64_t time) {
      ASSERT_LT(value, names.size());
      cycles[value] += time / kPeriodFs;
    });
    file.for_each_stretch(scope + "issue", 0, end_,
                          [&](std::uint64_t value, std::uint64_t time) { issued += value * (time / kPeriodFs); });
    EXPECT_EQ(issued, statistic(stats_, "gpu.sm" + std::to_string(sm) + ".rt.selections"));
  }
  EXPECT_EQ(cycles[0], statistic(stats_, "gpu.rt.selections"));
  for (std::size_t i = 1; i < names.size(); ++i) {
    EXPECT_EQ(cycles[i], statistic(stats_, "gpu.rt.stall." + names[i])) << names[i];
  }
}

TEST_P(WaveformExactness, BusyCyclesAndLevelsAddUp) {
  const VcdFile file = record();
  std::vector<const char*> units = {"ray_box", "ray_triangle"};
  if (checkpoint()) units.push_back("ray_transform");  // the two-level trace
  for (const char* unit : units) {
    const std::uint64_t busy = statistic(stats_, std::string("gpu.rt.") + unit + ".busy_cycles");
    EXPECT_GT(busy, 0U) << unit;
    EXPECT_EQ(sum(file, std::string("rt.") + unit + ".busy", file.end), busy) << unit;
  }
  EXPECT_EQ(sum(file, "rt.warp_buffer.occupancy", end_), statistic(stats_, "gpu.rt.occupancy_integral"));
  EXPECT_EQ(sum(file, "l1d.mshr", file.end), statistic(stats_, "gpu.l1.mshr_cycles"));
  std::uint64_t l2 = 0;
  for (const char* slice : {"gpu.l2_slice0.mshr", "gpu.l2_slice1.mshr"}) {
    file.for_each_stretch(slice, 0, file.end,
                          [&](std::uint64_t value, std::uint64_t time) { l2 += value * (time / kPeriodFs); });
  }
  EXPECT_EQ(l2, statistic(stats_, "gpu.l2.mshr_cycles"));
}

TEST_P(WaveformExactness, WarpActivitiesAddUp) {
  const VcdFile file = record();
  std::vector<std::uint64_t> cycles(modules::kWarpActivities + 1);
  for (const auto& [name, changes] : file.changes) {
    if (!name.ends_with(".activity")) continue;
    file.for_each_stretch(name, 0, file.end, [&](std::uint64_t value, std::uint64_t time) {
      ASSERT_LE(value, modules::kWarpActivities);
      cycles[value] += time / kPeriodFs;
    });
  }
  for (std::size_t a = 0; a < modules::kWarpActivities; ++a) {
    const std::string name(name_at<modules::WarpActivity>(a));
    EXPECT_EQ(cycles[a + 1], statistic(stats_, "gpu.simt.warp_cycles." + name)) << name;
    EXPECT_EQ(sum(file, "simt.warps_" + name, file.end), statistic(stats_, "gpu.simt.warp_cycles." + name)) << name;
  }
}

TEST_P(WaveformExactness, MessagesAndRequestsAreCounted) {
  const VcdFile file = record();
  EXPECT_EQ(sum(file, "rt_node_request.valid", file.end), statistic(stats_, "gpu.rt.node_sectors"));
  EXPECT_EQ(sum(file, "trace_call.valid", file.end), statistic(stats_, "gpu.rt.calls"));
  EXPECT_EQ(sum(file, "any_hit_batch.valid", file.end), statistic(stats_, "gpu.rt.any_hit.batches"));
  EXPECT_EQ(last(file, "rt.memory_scheduler.node_sectors"), statistic(stats_, "gpu.rt.node_sectors"));
  EXPECT_EQ(last(file, "rt.any_hit_collector.timeouts"), statistic(stats_, "gpu.rt.any_hit.timeouts"));
  std::uint64_t lanes = 0;  // of all any-hit batches
  for (unsigned sm = 0; sm < kSms; ++sm) {
    const std::string link = "gpu.sm" + std::to_string(sm) + ".any_hit_batch.";
    std::uint64_t time = 0;
    file.for_each_stretch(link + "valid", 0, file.end, [&](std::uint64_t valid, std::uint64_t duration) {
      for (std::uint64_t t = time; valid != 0 && t < time + duration; t += kPeriodFs) {
        lanes += static_cast<unsigned>(std::popcount(file.at(link + "lanes", t)));
      }
      time += duration;
    });
  }
  EXPECT_EQ(lanes, statistic(stats_, "gpu.rt.any_hit.lanes"));
  if (!checkpoint()) return;
  EXPECT_GT(last(file, "rt.checkpoint_unit.entries_written"), 0U);
  EXPECT_EQ(last(file, "rt.checkpoint_unit.entries_written"), statistic(stats_, "gpu.rt.checkpoint.entries_written"));
  EXPECT_EQ(last(file, "rt.checkpoint_unit.entries_read"), statistic(stats_, "gpu.rt.checkpoint.entries_read"));
  EXPECT_EQ(
      sum(file, "rt_checkpoint_request.valid", file.end),
      statistic(stats_, "gpu.rt.checkpoint.sectors_written") + statistic(stats_, "gpu.rt.checkpoint.sectors_read"));
}

TEST_P(WaveformExactness, HitsOfTheAnyHitUnitAreCounted) {
  const VcdFile file = record({}, {"rt.any_hit_unit.enabled=true"});
  EXPECT_GT(statistic(stats_, "gpu.rt.any_hit.unit.hits"), 0U);
  EXPECT_EQ(last(file, "rt.any_hit_unit.hits"), statistic(stats_, "gpu.rt.any_hit.unit.hits"));
  EXPECT_EQ(last(file, "rt.any_hit_unit.entered"), statistic(stats_, "gpu.rt.any_hit.unit.entered"));
  // A hit is held while its heap logic works for it and while it waits for that; one that falls out, until it is sent.
  const std::uint64_t held =
      statistic(stats_, "gpu.rt.any_hit.unit.busy_cycles") + statistic(stats_, "gpu.rt.any_hit.unit.wait_cycles");
  EXPECT_GE(sum(file, "rt.any_hit_unit.hits_held", file.end), held);
}

TEST_P(WaveformExactness, WarpsThatWalkTogetherShowWhatTheySchedule) {
  if (checkpoint()) GTEST_SKIP() << "has no replay";
  const VcdFile file = record({}, {"rt.traversal=warp", "rt.warp_stack.ahead=2"});
  const std::string unit = "rt.warp_walk_scheduler.";
  EXPECT_EQ(sum(file, unit + "issue", file.end), statistic(stats_, "gpu.rt.selections"));
  EXPECT_EQ(statistic(stats_, "gpu.rt.walk.entries"), statistic(stats_, "gpu.rt.selections"));
  EXPECT_GT(sum(file, unit + "waiting", file.end), 0U);
  EXPECT_GT(sum(file, unit + "under_way", file.end), 0U);
  EXPECT_GT(sum(file, unit + "hits", file.end), 0U);
}

TEST_P(WaveformExactness, LanesOfAWarpAreInOneStateEach) {
  const VcdFile file = record();
  std::uint64_t rounds = 0;
  for (const auto& [name, changes] : file.changes) {
    if (!name.ends_with(".active")) continue;
    const std::string warp = name.substr(0, name.rfind('.') + 1);
    std::vector<std::string> states;
    for (const auto& [other, width] : file.width) {
      if (other.starts_with(warp + "lanes_") && !other.ends_with("finished")) states.push_back(other);
    }
    ASSERT_GE(states.size(), 5U);
    for (const VcdFile::Change& change : changes) {
      // The last change of this moment counts.
      std::uint64_t all = 0, lanes = 0;
      for (const std::string& state : states) {
        const std::uint64_t mask = file.at(state, change.time);
        all |= mask;
        lanes += static_cast<unsigned>(std::popcount(mask));
      }
      const std::uint64_t active = file.at(name, change.time);
      EXPECT_EQ(all, active) << name << " at " << change.time;
      EXPECT_EQ(lanes, static_cast<unsigned>(std::popcount(active))) << name;
      EXPECT_EQ(file.at(warp + "node_lanes", change.time) & ~active, 0U) << name;
    }
    for (const VcdFile::Change& change : file.changes.at(warp + "k_buffer_fill")) EXPECT_LE(change.value, 64U);
    rounds += file.changes.at(warp + "group").size();
  }
  EXPECT_GT(rounds, 12U);
}

TEST_P(WaveformExactness, AWindowIsAPieceOfTheWhole) {
  const VcdFile whole = record();
  const CycleWindow window{3001, 4500};
  const VcdFile piece = record(window);
  EXPECT_EQ(piece.begin, window.first * kPeriodFs);
  EXPECT_EQ(piece.end, window.last * kPeriodFs);
  ASSERT_EQ(piece.width, whole.width);
  std::size_t compared = 0;
  for (const auto& [name, changes] : piece.changes) {
    // A link (it has a level) shows address, slot and lanes of its last message: a window may not have seen it.
    const std::string scope = name.substr(0, name.rfind('.') + 1);
    const std::string leaf = name.substr(scope.size());
    if (piece.width.contains(scope + "level") && (leaf == "address" || leaf == "slot" || leaf == "lanes")) continue;
    EXPECT_EQ(changes.front().value, whole.at(name, window.first * kPeriodFs)) << name;
    std::vector<VcdFile::Change> expected;
    for (const VcdFile::Change& change : whole.changes.at(name)) {
      if (change.time > piece.begin && change.time <= piece.end) expected.push_back(change);
    }
    EXPECT_EQ(std::vector<VcdFile::Change>(changes.begin() + 1, changes.end()), expected) << name;
    compared += expected.size();
  }
  EXPECT_GT(compared, 1000U);
}

TEST_P(WaveformExactness, SurvivesTheRoundTripThroughFst) {
  if (std::system("command -v vcd2fst >/dev/null && command -v fst2vcd >/dev/null") != 0) {
    GTEST_SKIP() << "vcd2fst and fst2vcd are not installed (package gtkwave)";
  }
  const VcdFile before = record({2000, 2600});
  const std::string vcd = run_.path("w.vcd"), fst = run_.path("w.fst"), back = run_.path("back.vcd");
  ASSERT_EQ(std::system(("vcd2fst '" + vcd + "' '" + fst + "' >/dev/null 2>&1").c_str()), 0);
  ASSERT_EQ(std::system(("fst2vcd '" + fst + "' > '" + back + "' 2>/dev/null").c_str()), 0);
  const VcdFile after = read_vcd(read_file(back));
  EXPECT_EQ(after.width, before.width);
  for (const auto& [name, changes] : before.changes) {
    for (const VcdFile::Change& change : changes) {
      ASSERT_EQ(after.at(name, change.time), before.at(name, change.time)) << name << " at " << change.time;
    }
    EXPECT_LE(after.changes.at(name).size(), changes.size() + 1) << name;
  }
}

TEST_P(WaveformExactness, DoesNotChangeAStatistic) {
  record();
  const nlohmann::ordered_json with = stats_;
  const nlohmann::ordered_json without = run_.run({});
  for (const auto& [name, entry] : without.items()) {
    if (name.starts_with("host.")) continue;
    EXPECT_EQ(with.at(name), entry) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Checkpointing, WaveformExactness, ::testing::Values(false, true),
                         [](const auto& test_case) { return test_case.param ? "on" : "off"; });

}  // namespace
}  // namespace grtx::sim
