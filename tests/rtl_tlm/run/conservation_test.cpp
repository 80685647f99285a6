// SPDX-License-Identifier: Apache-2.0
// Each conservation law fails when its counter is off by one.
#include "grtx/rtl_tlm/run/conservation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

namespace grtx::sim {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// An empty run of 100 cycles on two RT units: every law holds.
GpuCounters idle_run() {
  GpuCounters c;
  c.cycles = 100;
  c.rt.units = 2;
  c.rt.scheduler.stall[static_cast<std::size_t>(modules::Stall::empty)] = 200;
  return c;
}

TEST(Conservation, HoldsForAnIdleRun) { EXPECT_THAT(count_violations(idle_run(), {}, 0), ::testing::IsEmpty()); }

TEST(Conservation, EveryTotalOfTheTraceIsChecked) {
  using traces::Totals;
  const std::vector<std::pair<std::uint64_t Totals::*, const char*>> cases = {
      {&Totals::rounds, "ray rounds executed: 0 instead of 1"},
      {&Totals::visits_internal, "internal node visits"},
      {&Totals::visits_instance, "instance leaf visits"},
      {&Totals::visits_leaf, "primitive leaf visits"},
      {&Totals::culls, "culls"},
      {&Totals::any_hit_calls, "any-hit calls of the RT units"},
      {&Totals::evictions, "evictions"},
      {&Totals::checkpoints_written, "checkpoints written"},
      {&Totals::checkpoints_read, "checkpoints read"},
      {&Totals::processed, "k-buffer entries processed"},
      {&Totals::blended, "k-buffer entries blended"}};
  for (const auto& [member, text] : cases) {
    Totals totals;
    totals.*member = 1;
    EXPECT_THAT(count_violations(idle_run(), totals, 0), ::testing::Contains(HasSubstr(text)));
  }
  EXPECT_THAT(count_violations(idle_run(), {}, 3), ElementsAre("warps ended: 0 instead of 3"));
}

TEST(Conservation, EveryLevelAnswersItsRequests) {
  using Change = std::function<void(GpuCounters&, MemoryTraffic&)>;
  const std::vector<std::pair<Change, const char*>> cases = {
      {[](auto& c, auto&) { c.rt.prefetch.sectors = 1; }, "L1 accesses: 0 instead of 1"},
      {[](auto& c, auto&) { c.l1.prefetches = 1; }, "L1 responses: 0 instead of 1"},
      {[](auto& c, auto&) { c.l1.sent_reads = 1; }, "L1 fills: 0 instead of 1"},
      {[](auto& c, auto&) { c.l1.sent_writes = 1; }, "packets into the request network: 0 instead of 1"},
      {[](auto& c, auto&) { c.crossbar.request.packets_in = 1; }, "packets out of the request network: 0 instead of 1"},
      {[](auto& c, auto&) { c.l2.requests_in = 1; }, "L2 replies: 0 instead of 1"},
      {[](auto& c, auto&) { c.l2.replies_out = 1; }, "packets into the reply network: 0 instead of 1"},
      {[](auto& c, auto&) { c.l2.dram_reads = 1; }, "DRAM reads: 0 instead of 1"},
      {[](auto& c, auto&) { c.l2.dram_writes = 1; }, "DRAM writes: 0 instead of 1"},
      {[](auto&, auto& d) { d.responses = 1; }, "DRAM responses: 1 instead of 0"},
      {[](auto&, auto& d) { d.refused = 1; }, "DRAM refusals: 1 instead of 0"},
      {[](auto& c, auto&) { c.cycles = 101; }, "RT unit cycles accounted for: 200 instead of 202"},
      {[](auto& c, auto&) { c.simt.shader.k_buffer_mismatches = 1; }, "k-buffer mismatches: 1 instead of 0"}};
  for (const auto& [change, text] : cases) {
    GpuCounters counters = idle_run();
    change(counters, counters.memory.traffic);
    EXPECT_THAT(count_violations(counters, {}, 0), ::testing::Contains(text));
  }
}

TEST(Conservation, EveryRegionIsCheckedOnEveryLevel) {
  using modules::index;
  using modules::Region;
  using Change = std::function<void(GpuCounters&)>;
  const std::vector<std::pair<Change, const char*>> cases = {
      {[](auto& c) { c.rt.checkpoint.sectors_written = 1; }, "L1 writes of checkpoint entries: 0 instead of 1"},
      {[](auto& c) { c.rt.checkpoint.sectors_read = 1; }, "L1 reads of checkpoint entries: 0 instead of 1"},
      {[](auto& c) { c.rt.stack.spills = 1; }, "L1 writes of stack entries: 0 instead of 1"},
      {[](auto& c) { c.rt.stack.fills = 1; }, "L1 reads of stack entries: 0 instead of 1"},
      {[](auto& c) { c.l1.region[index(Region::leaf)].reads = 1; }, "L1 reads of nodes: 1 instead of 0"},
      {[](auto& c) { c.l1.region[index(Region::k_buffer)].reads = 1; }, "L1 reads of region k_buffer: 1 instead of 0"},
      {[](auto& c) { c.simt.memory.stores[index(Region::eviction)] = 1; },
       "L1 writes of region eviction: 0 instead of 1"},
      {[](auto& c) { c.l1.region[index(Region::sh)].misses = 1; }, "L2 reads of region sh: 0 instead of 1"},
      {[](auto& c) { c.l2.region[index(Region::blas)].misses = 1; }, "DRAM reads of region blas: 0 instead of 1"},
      {[](auto& c) {
         c.l1.sent_writes = 1;
         c.l1.region[index(Region::eviction)].writes = 1;
       },
       "L2 writes of region eviction: 0 instead of 1"},
      {[](auto& c) { c.l1.region[index(Region::tlas)].misses = 1; }, "L2 reads of all regions: 0 instead of 1"},
      {[](auto& c) { c.l2.region[index(Region::ray)].writes = 1; }, "L2 writes of all regions: 1 instead of 0"},
      {[](auto& c) { c.l2.dram_reads = 1; }, "DRAM reads of all regions: 0 instead of 1"},
      {[](auto& c) { c.l2.dram_writes = 1; }, "DRAM writes of all regions: 0 instead of 1"}};
  for (const auto& [change, text] : cases) {
    GpuCounters counters = idle_run();
    change(counters);
    EXPECT_THAT(count_violations(counters, {}, 0), ::testing::Contains(text));
  }
}

TEST(Conservation, ARunMayNotBeFasterThanABound) {
  EXPECT_THAT(bound_violations(100, {{"rt_port", 100, ""}, {"issue", 99, ""}}), ::testing::IsEmpty());
  EXPECT_THAT(bound_violations(100, {{"rt_port", 101, ""}, {"issue", 99, ""}}),
              ElementsAre("100 cycles are below the lower bound rt_port of 101"));
}

}  // namespace
}  // namespace grtx::sim
