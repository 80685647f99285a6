// Work beside: a share of issue slots, of L1 cycles and of DRAM bursts. docs/model/other-work.md.
#include <gtest/gtest.h>

#include "grtx/rtl_tlm/estimate/fast/fast_dram.h"
#include "rtl_tlm/observe/observed_run.h"

namespace grtx::sim {
namespace {

using test::statistic;
constexpr const char* kKeys[] = {"simt.other_share", "l1.other_share", "dram.other_share"};

nlohmann::ordered_json counts(const nlohmann::ordered_json& stats) {
  nlohmann::ordered_json rest = nlohmann::ordered_json::object();
  for (const auto& [name, entry] : stats.items()) {
    if (!name.starts_with("host.")) rest[name] = entry;
  }
  return rest;
}

TEST(OtherWorkInARun, AShareOfZeroChangesNothing) {
  const test::ObservedRun run;
  for (const SimulationMode mode : {SimulationMode::cycle, SimulationMode::fast}) {
    const auto usual = counts(run.run({}, {}, mode));
    for (const std::string key : kKeys) EXPECT_EQ(counts(run.run({}, {key + "=0"}, mode)), usual) << key;
  }
}

// What the trace says is done, no less and no more, and later. ObservedRun holds the laws of conservation.
TEST(OtherWorkInARun, TheSameWorkTakesLonger) {
  const test::ObservedRun run;
  for (const SimulationMode mode : {SimulationMode::cycle, SimulationMode::fast}) {
    const auto usual = run.run({}, {}, mode);
    for (const std::string key : kKeys) {
      const auto shared = run.run({}, {key + "=0.8"}, mode);
      for (const char* same : {"gpu.rt.node_visits", "gpu.rt.any_hit_calls", "gpu.simt.processed", "gpu.simt.warps"}) {
        EXPECT_EQ(statistic(shared, same), statistic(usual, same)) << key << " " << same;
      }
      EXPECT_GT(statistic(shared, "gpu.cycles"), statistic(usual, "gpu.cycles")) << key;
    }
  }
}

// With prologues so long that nothing else counts, a run is as long as its instructions over what is left to them.
TEST(OtherWorkInARun, ARunOfInstructionsIsLongerByOneOverWhatIsLeft) {
  const test::ObservedRun run;
  const std::vector<std::string> usual = {"simt.cost.raygen_prologue=1000000"};
  for (const SimulationMode mode : {SimulationMode::cycle, SimulationMode::fast}) {
    const auto alone = static_cast<double>(statistic(run.run({}, usual, mode), "gpu.cycles"));
    for (const double share : {0.25, 0.75}) {
      std::vector<std::string> settings = usual;
      settings.push_back("simt.other_share=" + std::to_string(share));
      const auto shared = static_cast<double>(statistic(run.run({}, settings, mode), "gpu.cycles"));
      EXPECT_NEAR(shared / alone, 1 / (1 - share), 0.06 / (1 - share)) << share;
    }
  }
}

TEST(OtherWorkInARun, FastModeFollowsCycleMode) {
  const test::ObservedRun run(true, true, 0, true);
  for (const std::string key : kKeys) {
    for (const std::string share : {"0.3", "0.6"}) {
      const auto cycle = static_cast<double>(statistic(run.run({}, {key + "=" + share}), "gpu.cycles"));
      const auto fast =
          static_cast<double>(statistic(run.run({}, {key + "=" + share}, SimulationMode::fast), "gpu.cycles"));
      EXPECT_NEAR(fast, cycle, 0.12 * cycle) << key << " " << share;
    }
  }
}

// Row hits in a stream: the bus is all that counts.
TEST(OtherWorkInARun, AStreamOfTheDramOfFastModeIsLongerByOneOverWhatIsLeft) {
  const auto clocks = [](double share) {
    modules::DramChannelConfig config{.other_share = share};
    FastDramChannel channel(config);
    Cycle done = 0;
    for (std::uint64_t i = 0; i < 6000; ++i) {
      const Cycle now = done > 200 ? done - 200 : 0;
      channel.advance(now);
      done = channel.request(now, i * 32, 1, 32, false);
    }
    return static_cast<double>(done);
  };
  const double alone = clocks(0.0);
  EXPECT_NEAR(alone, 6000.0 * 4, 0.02 * 6000 * 4);
  for (const double share : {0.25, 0.5, 0.75}) {
    EXPECT_NEAR(clocks(share) / alone, 1 / (1 - share), 0.05 / (1 - share)) << share;
  }
}

}  // namespace
}  // namespace grtx::sim
