// SPDX-License-Identifier: Apache-2.0
// The RT unit alone on random traces: nothing depends on the construction order or on idle skip. That every event is
// executed once and every request answered is a law of each run (conservation.cpp), to the number in
// tests/rtl_tlm/plain.
#include <gmock/gmock.h>

#include "rtl_tlm/rt_unit/rt_bench.h"
#include "traces/random_group.h"

namespace grtx::sim {
namespace {

using namespace test;
using traces::testing::random_trace;
using traces::testing::RandomOptions;

class RtUnitConservationTest : public modules::SystemCTest {};

void launch_all(RtBench& bench, const std::vector<traces::RayGroup>& groups) {
  for (std::size_t g = 0; g < groups.size(); ++g) {
    bool any = false;
    for (const auto& ray : groups[g].rays) any = any || !ray.rounds.empty();
    if (any) bench.launch(groups[g], static_cast<std::uint16_t>(g));
  }
}

TEST_F(RtUnitConservationTest, StatisticsDoNotDependOnConstructionOrderOrIdleSkip) {
  for (const bool two_level : {false, true}) {
    RandomOptions random{.seed = 77, .groups = 10, .warp_size = 32, .two_level = two_level};
    const auto trace = random_trace(random);
    std::string reference;
    for (const bool idle_skip : {true, false}) {
      for (const unsigned order : {0u, 1u, 2u}) {
        BenchOptions options;
        options.idle_skip = idle_skip;
        options.construction_order = order;
        RtBench bench(trace.header, options);
        launch_all(bench, trace.groups);
        bench.run();
        const std::string statistics = bench.statistics();
        if (reference.empty()) reference = statistics;
        EXPECT_EQ(statistics, reference) << "idle skip " << idle_skip << " order " << order;
      }
    }
    EXPECT_GT(reference.size(), 1000u);
  }
}

TEST_F(RtUnitConservationTest, AddedInventoryIsThePapersTable) {
  const std::vector<std::pair<unsigned, std::uint64_t>> table = {{4, 546}, {8, 1074}, {16, 2130}, {32, 4242}};
  for (const auto& [warps, bytes] : table) {
    for (const bool checkpoint : {true, false}) {
      BenchOptions options;
      options.rt.warp_buffer.entries = warps;
      RtBench bench(small_header("tri20", checkpoint ? 64 : 0), options);
      std::uint64_t bits = 0;
      for (const auto& module : bench.rt().inventory()) {
        for (const auto& s : module.storage) bits += s.added_by_grtx ? s.bits : 0;
      }
      EXPECT_EQ(bits, checkpoint ? 8 * bytes : 0) << warps;
    }
  }
}

}  // namespace
}  // namespace grtx::sim
