// SPDX-License-Identifier: Apache-2.0
// SMs with several RT units: waveform and timeline show each unit under its own name, add up to the statistics, and
// change none of them.
#include <gtest/gtest.h>

#include <string>

#include "grtx/base/atomic_file.h"
#include "grtx/rtl_tlm/observe/stall_follower.h"
#include "rtl_tlm/observe/observed_run.h"
#include "rtl_tlm/observe/vcd_reader.h"

namespace grtx::sim {
namespace {

using test::statistic;

constexpr std::uint64_t kPeriodFs = 732601;  // 1 / 1365 MHz
const std::vector<std::string> kTwoUnits = {"gpu.rt_units=2"};

nlohmann::ordered_json without_host(const nlohmann::ordered_json& stats) {
  nlohmann::ordered_json rest = nlohmann::ordered_json::object();
  for (const auto& [name, entry] : stats.items()) {
    if (!name.starts_with("host.")) rest[name] = entry;
  }
  return rest;
}

TEST(ObservedRtUnits, WaveformAndTimelineChangeNoStatistic) {
  const test::ObservedRun run;
  SimulationOptions observed;
  observed.waveform.path = run.path("w.vcd");
  observed.timeline.path = run.path("t.json");
  const auto plain = without_host(run.run({}, kTwoUnits));
  EXPECT_EQ(without_host(run.run(observed, kTwoUnits)), plain);
  EXPECT_GT(plain.size(), 100U);
}

TEST(ObservedRtUnits, EachUnitsCyclesAreInTheWaveform) {
  const test::ObservedRun run;
  SimulationOptions options;
  options.waveform.path = run.path("w.vcd");
  const auto stats = run.run(options, kTwoUnits);
  const VcdFile file = read_vcd(read_file(options.waveform.path));
  const std::uint64_t end = statistic(stats, "gpu.cycles") * kPeriodFs;
  std::vector<std::uint64_t> cycles(StallFollower::names().size());
  std::uint64_t warps = 0;
  for (const std::string sm : {"sm0", "sm1"}) {
    for (const std::string unit : {"rt", "rt1"}) {
      const std::string scope = "gpu." + sm + "." + unit;
      std::uint64_t issued = 0;
      file.for_each_stretch(scope + ".rt_scheduler.stall_reason", 0, end, [&](std::uint64_t value, std::uint64_t time) {
        cycles.at(value) += time / kPeriodFs;
        if (value == 0) issued += time / kPeriodFs;
      });
      EXPECT_EQ(issued, statistic(stats, "gpu." + sm + "." + unit + ".selections"));
      EXPECT_GT(issued, 0U) << scope;
      file.for_each_stretch(scope + ".warp_buffer.occupancy", 0, end,
                            [&](std::uint64_t value, std::uint64_t time) { warps += value * (time / kPeriodFs); });
    }
  }
  EXPECT_EQ(cycles[0], statistic(stats, "gpu.rt.selections"));
  for (std::size_t i = 1; i < cycles.size(); ++i) {
    EXPECT_EQ(cycles[i], statistic(stats, "gpu.rt.stall." + StallFollower::names()[i])) << i;
  }
  EXPECT_EQ(warps, statistic(stats, "gpu.rt.occupancy_integral"));
}

TEST(ObservedRtUnits, TheTimelineHasATrackForEachUnit) {
  const test::ObservedRun run;
  SimulationOptions options;
  options.timeline.path = run.path("t.json");
  run.run(options, kTwoUnits);
  const auto timeline = nlohmann::json::parse(read_file(options.timeline.path));
  unsigned first = 0, second = 0;
  for (const auto& event : timeline.at("traceEvents")) {
    if (event.at("ph") != "M" || event.at("name") != "thread_name") continue;
    const std::string name = event.at("args").at("name");
    first += name.starts_with("ray_") || name == "rt_scheduler";
    second += name.starts_with("rt1.");
  }
  EXPECT_GT(second, 0U);
  EXPECT_EQ(first, second);  // as many tracks for the second unit as for the first
}

}  // namespace
}  // namespace grtx::sim
