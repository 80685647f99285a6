// Fast mode does the same work as the cycle model, keeps its conservation laws, gives the same answer each time, and
// comes close to its cycles.
#include <gtest/gtest.h>

#include <ostream>
#include <string>
#include <vector>

#include "rtl_tlm/observe/observed_run.h"

namespace grtx::sim {
namespace {

using test::statistic;

nlohmann::ordered_json without_host(const nlohmann::ordered_json& stats) {
  nlohmann::ordered_json rest = nlohmann::ordered_json::object();
  for (const auto& [name, entry] : stats.items()) {
    if (!name.starts_with("host.")) rest[name] = entry;
  }
  return rest;
}

struct Machine {
  const char* name;
  bool checkpoint;
  std::vector<std::string> settings;
  double tolerance;      ///< of the cycles, relative
  unsigned objects = 0;  ///< below a scene TLAS
  friend void PrintTo(const Machine& machine, std::ostream* out) { *out << machine.name; }
};

class FastMode : public ::testing::TestWithParam<Machine> {
 protected:
  test::ObservedRun run_{GetParam().checkpoint, GetParam().checkpoint, GetParam().objects};
};

// ObservedRun fails when a conservation law does not hold.
TEST_P(FastMode, DoesTheWorkOfTheCycleModelInAboutItsTime) {
  const auto cycle = run_.run({}, GetParam().settings);
  const auto quick = run_.run({}, GetParam().settings, SimulationMode::fast);
  for (const char* same :
       {"gpu.rt.node_visits", "gpu.rt.visits_internal", "gpu.rt.visits_instance", "gpu.rt.visits_leaf", "gpu.rt.culls",
        "gpu.rt.any_hit_calls", "gpu.rt.calls", "gpu.rt.max_stack_depth", "gpu.rt.stack.spills", "gpu.rt.stack.fills",
        "gpu.rt.stack.max_spilled", "gpu.simt.warps"}) {
    EXPECT_EQ(statistic(quick, same), statistic(cycle, same)) << same;
  }
  EXPECT_GT(statistic(cycle, "gpu.rt.node_visits"), 0U);
  const auto expected = static_cast<double>(statistic(cycle, "gpu.cycles"));
  EXPECT_NEAR(static_cast<double>(statistic(quick, "gpu.cycles")), expected, GetParam().tolerance * expected);
}

TEST_P(FastMode, GivesTheSameEachTime) {
  EXPECT_EQ(without_host(run_.run({}, GetParam().settings, SimulationMode::fast)),
            without_host(run_.run({}, GetParam().settings, SimulationMode::fast)));
}

// Twelve warps of random rays: their run ends with one of them, so single runs scatter.
INSTANTIATE_TEST_SUITE_P(
    Machines, FastMode,
    ::testing::Values(Machine{"baseline", false, {}, 0.06}, Machine{"grtx", true, {}, 0.06},
                      Machine{"grtx_objects", true, {}, 0.06, 3},
                      Machine{"spilling", false, {"rt.warp_buffer.stack_entries=2"}, 0.06},
                      Machine{"spilling_checkpoints", true, {"rt.warp_buffer.stack_entries=2"}, 0.06},
                      Machine{"perfect_l1", true, {"l1.perfect=true"}, 0.06},
                      Machine{"perfect_dram", true, {"dram.perfect=true"}, 0.06},
                      Machine{"two_mshrs", true, {"l1.mshr_entries=2"}, 0.12},
                      Machine{"l1_links_of_one", true, {"l1.link_capacity=1"}, 0.06},
                      Machine{"crossbar_links_of_one", true, {"crossbar.link_capacity=1"}, 0.06},
                      Machine{"no_prefetch", true, {"rt.prefetch.enabled=false"}, 0.06},
                      Machine{"private_stores",
                              true,
                              {"simt.private_store.k_buffer_entries=4", "simt.private_store.eviction_entries=2"},
                              0.06},
                      Machine{"written_back", true, {"l1.private_writes=write_back", "l1.private_allocate=true"}, 0.06},
                      Machine{"no_merging", false, {"rt.memory.merge_in_flight=false"}, 0.06}),
    [](const auto& i) { return std::string(i.param.name); });

// The second SM to ask for a sector had it at once, and all sectors of a miss came as late as if they had been looked
// up with the last.
TEST(FastModeL2, ASectorUnderWayIsWaitedForAndAMissTakesTheCycleModelsTime) {
  const test::ObservedRun run(false, false);
  const auto latency = [](const auto& stats) {
    return stats.at("gpu.l2.miss_latency").at("value").template get<double>();
  };
  for (const char* channels : {"dram.channels=2", "dram.channels=1"}) {
    const auto cycle = run.run({}, {channels});
    const auto quick = run.run({}, {channels}, SimulationMode::fast);
    EXPECT_GT(statistic(cycle, "gpu.l2.all.hits_on_miss"), 20U);
    EXPECT_NEAR(static_cast<double>(statistic(quick, "gpu.l2.all.hits_on_miss")),
                static_cast<double>(statistic(cycle, "gpu.l2.all.hits_on_miss")), 10.0);
    EXPECT_NEAR(latency(quick), latency(cycle), 1.0) << channels;
  }
}

// What had left an L2 waited in the books of an idle DRAM for the next read: 700 clocks in place of 30.
TEST(FastModeDram, WritesOfAnIdleMemoryDoNotWaitForTheNextRead) {
  const test::ObservedRun run;
  const auto latency = [&](SimulationMode mode) {
    return run.run({}, {}, mode).at("gpu.dram.access_latency").at("value").get<double>();
  };
  const double expected = latency(SimulationMode::cycle);
  EXPECT_NEAR(latency(SimulationMode::fast), expected, expected);
}

// It kept every fill, where the cycle model dropped half of them.
TEST(FastModeWrittenBack, DropsFillsWhereTheCycleModelDoes) {
  const test::ObservedRun run(true, true);
  struct Case {
    const char *ways, *allocate, *lines;
    bool drops;
  };
  // In a set of sixteen there is a clean line to replace, unless each write takes a line.
  for (const Case c : {Case{"1", "true", "1", true}, Case{"1", "true", "64", false}, Case{"16", "false", "1", false}}) {
    for (const SimulationMode mode : {SimulationMode::cycle, SimulationMode::fast}) {
      const auto stats =
          run.run({},
                  {"l1.private_writes=write_back", "l1.bytes=2048", std::string("l1.ways=") + c.ways,
                   std::string("l1.private_allocate=") + c.allocate, std::string("l1.write_back_buffer=") + c.lines},
                  mode);
      EXPECT_GT(statistic(stats, "gpu.l1.write_backs"), 0U);
      EXPECT_EQ(statistic(stats, "gpu.l1.fills_bypassed") > 0, c.drops) << name_of(mode) << ", " << c.ways << " ways";
    }
  }
}

TEST(FastModeRefuses, WhatItDoesNotModel) {
  const test::ObservedRun run;
  const auto refused = [&](const SimulationOptions& options, const std::vector<std::string>& settings) {
    try {
      run.run(options, settings, SimulationMode::fast);
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refused({}, {"gpu.rt_units=2"}).find("gpu.rt_units"), std::string::npos);
  EXPECT_NE(refused({}, {"rt.memory.by_shader=true"}).find("rt.memory.by_shader"), std::string::npos);
  SimulationOptions waveform;
  waveform.waveform.path = run.path("w.vcd");
  EXPECT_NE(refused(waveform, {}).find("--mode cycle"), std::string::npos);
}

}  // namespace
}  // namespace grtx::sim
