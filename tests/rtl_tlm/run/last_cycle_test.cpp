// SPDX-License-Identifier: Apache-2.0
// What still comes back in the very cycle in which the last warp is seen to have ended is no part of the run.
#include <gtest/gtest.h>

#include "rtl_tlm/rt_unit/directed.h"

namespace grtx::sim {
namespace {

using namespace test;

// A ray visits one of six leaves; its five siblings are prefetched, ten sectors that the DRAM delivers one every ten
// cycles, and culled. The last of them come back after the end. The epilogue's cost moves the end by a cycle at a time,
// so that in one of the runs it meets a prefetch.
TEST(LastCycle, APrefetchAnsweredInItCountsNoStall) {
  Directed d = directed(1, 1);
  d.groups[0].nodes = {node(1, 2, 6, NodeKind::triangle)};
  std::vector<Event> events = {internal_event(0, 0b111111), leaf_event(7, LeafOutcome::miss)};
  for (std::uint32_t leaf = 6; leaf >= 2; --leaf) events.push_back(cull_event(leaf, 0));
  add_round(d.groups[0].rays[0], events);
  const traces::testing::TemporaryFile file("last_cycle");
  traces::Header header = d.header;
  header.groups = 1;
  traces::testing::write_trace(file.path(), header, d.groups);
  for (const char* epilogue : {"0", "1", "2", "3", "4", "5", "6", "7", "8", "9"}) {
    ChildProcess child("simulation", [&] {
      const GpuConfig config =
          load_config("", {"gpu.sms=1", "gpu.resident_warps=1", "gpu.core_mhz=1000", "dram.mhz=1000", "l2.slices=1",
                           "l2.latency=1", "crossbar.latency=1", "rt.triangle.latency=1", "dram.fixed_latency=0",
                           "dram.timing.ccd=10", std::string("simt.cost.epilogue=") + epilogue});
      const SimulationResult result = simulate(file.path(), config, {});
      const auto& stats = result.document.at("stats");
      // Five leaves of two sectors, of which the first run's end comes before the last.
      EXPECT_EQ(stats.at("gpu.rt.prefetch.sectors").at("value"), 10);
      return ordered_json(result.violations).dump();
    });
    EXPECT_EQ(child.result(), "[]") << "epilogue of " << epilogue;
  }
}

}  // namespace
}  // namespace grtx::sim
