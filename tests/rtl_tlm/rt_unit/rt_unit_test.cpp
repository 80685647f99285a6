// SPDX-License-Identifier: Apache-2.0
// Closed forms of the RT unit's timing (docs/model/rt_scheduler.md), cycle by cycle.
#include "grtx/modules/rt_unit/rt_unit.h"

#include <gmock/gmock.h>

#include "parameter_names.h"
#include "rtl_tlm/rt_unit/rt_bench.h"

namespace grtx::sim {
namespace {

using namespace test;
using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;

class RtUnitTest : public modules::SystemCTest {};

// The SIMT core sends the call in cycle 0, it is visible and accepted in cycle 1 and first scheduled in cycle 2.
constexpr Cycle kFirst = 2;
constexpr std::uint64_t kUnit = traces::kNodeUnit;

/// `lanes` rays that each visit `visits` internal nodes one after the other; address(lane, i) names them in node units.
template <typename F>
traces::RayGroup chase(unsigned lanes, unsigned visits, F&& address) {
  traces::RayGroup group;
  const auto node = [&](unsigned lane, unsigned visit) { return static_cast<std::uint32_t>(address(lane, visit)); };
  std::map<std::uint32_t, std::uint32_t> index;
  for (unsigned l = 0; l < lanes; ++l) {
    for (unsigned i = 0; i < visits; ++i) index[node(l, i)] = 0;
  }
  for (auto& [at, place] : index) {
    place = static_cast<std::uint32_t>(group.nodes.size());
    group.nodes.push_back(node_definition(at, at + 1, {NodeKind::internal}));
  }
  group.rays.resize(lanes);
  for (unsigned l = 0; l < lanes; ++l) {
    std::vector<Event> events;
    for (unsigned i = 0; i < visits; ++i) events.push_back(internal_event(index[node(l, i)], i + 1 < visits ? 1 : 0));
    add_round(group.rays[l], events);
  }
  return group;
}

struct ChaseCase {
  unsigned visits;
  unsigned memory_latency;
  unsigned box_latency;
  friend void PrintTo(const ChaseCase& c, std::ostream* out) {
    *out << c.visits << " visits, memory " << c.memory_latency << ", box " << c.box_latency;
  }
};

class PointerChase : public modules::SystemCTest, public ::testing::WithParamInterface<ChaseCase> {};

// One visit takes: 2 sectors issued in the two cycles after the scheduling, the memory latency of the second, one cycle
// to the unit's start, and the unit's latency; the lane is scheduled again in the cycle of the result.
TEST_P(PointerChase, TakesVisitsTimesTheSumOfTheStages) {
  const auto [visits, memory, box] = GetParam();
  BenchOptions options;
  options.memory_latency = memory;
  options.rt.ray_box.latency = box;
  const auto group = chase(1, visits, [](unsigned, unsigned i) { return 1 + i; });
  RtBench bench(small_header(), options);
  bench.run(group, 3);
  ASSERT_EQ(bench.dones.size(), 1u);
  EXPECT_EQ(bench.dones[0].slot, 3);
  EXPECT_EQ(bench.dones[0].cycle, kFirst + visits * (2 + memory + 1 + box));
  const auto c = bench.counters();
  EXPECT_EQ(c.memory.node_visits(), visits);
  EXPECT_EQ(c.memory.node_fetches(), visits);
  EXPECT_EQ(c.memory.node_sectors(), 2 * visits);
  EXPECT_EQ(c.memory.fetch_latency.sum(), visits * (2 + memory));
  EXPECT_EQ(c.scheduler.selections, visits);
  EXPECT_EQ(c.warp_buffer.occupancy_integral, bench.dones[0].cycle - 1);  // accepted in cycle 1
  // Every cycle is a selection or has a reason: 2 empty, visits x (memory + unit), one for the retirement.
  using modules::Stall;
  const auto stall = [&](Stall s) { return c.scheduler.stall[static_cast<std::size_t>(s)]; };
  EXPECT_EQ(stall(Stall::empty), kFirst + 1);  // cycles 0, 1 and that of the retirement
  EXPECT_EQ(stall(Stall::memory), visits * (2 + memory - 1));
  EXPECT_EQ(stall(Stall::unit), visits * (box + 1));
}
INSTANTIATE_TEST_SUITE_P(Table, PointerChase,
                         ::testing::Values(ChaseCase{1, 2, 1}, ChaseCase{1, 20, 13}, ChaseCase{7, 20, 13},
                                           ChaseCase{50, 300, 31}),
                         grtx::test::PrintedName{});

TEST_F(RtUnitTest, WithoutMergingInFlightFewPipelinesTearACoherentWarpApart) {
  constexpr unsigned kVisits = 5;
  BenchOptions options;
  options.rt.memory.merge_in_flight = false;
  const auto group = chase(32, kVisits, [](unsigned, unsigned i) { return 1 + i; });
  RtBench bench(small_header(), options);
  bench.run(group);
  const auto c = bench.counters();
  EXPECT_EQ(c.memory.node_visits(), 32 * kVisits);
  // Four pipelines take eight cycles for 32 lanes: the lanes come back in eight fours, four lanes per cycle, and each
  // four is scheduled in a cycle of its own from then on.
  EXPECT_EQ(c.memory.node_fetches(), 1 + (kVisits - 1) * 8);
  EXPECT_EQ(c.ray_box.operations, 32 * kVisits);
}

TEST_F(RtUnitTest, CoherentWarpStaysTogetherWithAPipelineALane) {
  constexpr unsigned kVisits = 5;
  BenchOptions options;
  options.rt.ray_box.count = 32;
  const auto group = chase(32, kVisits, [](unsigned, unsigned i) { return 1 + i; });
  RtBench bench(small_header(), options);
  bench.run(group);
  EXPECT_EQ(bench.counters().memory.node_fetches(), kVisits);
  EXPECT_EQ(bench.dones[0].cycle, kFirst + kVisits * (2 + 20 + 1 + 13));
  EXPECT_DOUBLE_EQ(bench.counters().scheduler.simt_efficiency(), 1.0);
}

TEST_F(RtUnitTest, CoherentWarpMergesEachVisitIntoOneFetch) {
  constexpr unsigned kVisits = 5;
  const auto group = chase(32, kVisits, [](unsigned, unsigned i) { return 1 + i; });
  RtBench bench(small_header(), {});
  bench.run(group);
  // All eight fours ask within eight cycles, less than the memory latency.
  EXPECT_EQ(bench.counters().memory.node_fetches(), kVisits);
  EXPECT_EQ(bench.counters().ray_box.operations, 32 * kVisits);
}

TEST_F(RtUnitTest, DivergentWarpIsBoundByOneSectorACycle) {
  BenchOptions options;
  const auto group = chase(32, 1, [](unsigned l, unsigned) { return 1 + l; });
  RtBench bench(small_header(), options);
  bench.run(group);
  EXPECT_EQ(bench.counters().memory.node_fetches(), 32u);
  // 64 sectors in 64 cycles; the last one's node follows alone through the pipeline.
  EXPECT_EQ(bench.dones[0].cycle, kFirst + 64 + 20 + 1 + 13);
  ASSERT_EQ(bench.requests[0].size(), 64u);
  for (std::size_t i = 0; i < 64; ++i) {
    EXPECT_EQ(bench.requests[0][i].request.address, kUnit + 32 * i);
    EXPECT_EQ(bench.requests[0][i].cycle, kFirst + 1 + i);
  }
}

struct ThroughputCase {
  unsigned count;
  unsigned interval;
  friend void PrintTo(const ThroughputCase& c, std::ostream* out) {
    *out << c.count << " units, interval " << c.interval;
  }
};
class UnitThroughput : public modules::SystemCTest, public ::testing::WithParamInterface<ThroughputCase> {};

// 32 lanes arrive at once at a unit: the last of them starts after ceil(32 / count) - 1 intervals.
TEST_P(UnitThroughput, LimitsTheLanesOfOneFetch) {
  const auto [count, interval] = GetParam();
  BenchOptions options;
  options.rt.ray_box = {count, 13, interval};
  const auto group = chase(32, 1, [](unsigned, unsigned) { return 1; });
  RtBench bench(small_header(), options);
  bench.run(group);
  const Cycle rounds = (32 + count - 1) / count;
  EXPECT_EQ(bench.dones[0].cycle, kFirst + 2 + 20 + 1 + (rounds - 1) * interval + 13);
  EXPECT_EQ(bench.counters().ray_box.busy_cycles, 32u * interval);
}
INSTANTIATE_TEST_SUITE_P(Table, UnitThroughput,
                         ::testing::Values(ThroughputCase{1, 1}, ThroughputCase{1, 3}, ThroughputCase{4, 1},
                                           ThroughputCase{4, 2}, ThroughputCase{5, 3}, ThroughputCase{32, 1}),
                         grtx::test::PrintedName{});

TEST_F(RtUnitTest, BoxOperationPerChildTakesAChildAnInterval) {
  BenchOptions options;
  options.rt.box_op_per_child = true;
  traces::RayGroup group;
  group.nodes = {node_definition(1, 2, std::vector<NodeKind>(5, NodeKind::internal))};
  group.rays.resize(1);
  add_round(group.rays[0], {internal_event(0, 0)});
  RtBench bench(small_header(), options);
  bench.run(group);
  EXPECT_EQ(bench.dones[0].cycle, kFirst + 2 + 20 + 1 + 13 + 4);
  EXPECT_EQ(bench.counters().ray_box.tests, 5u);
}

struct SectorCase {
  const char* what;
  modules::NodeTrafficConfig traffic;
  std::vector<std::uint64_t> addresses;
};

// Instance leaf at unit 100 of a two-level structure, BLAS header at 2^19, leaf inside the BLAS at unit 9000.
TEST_F(RtUnitTest, VisitsReadTheConfiguredSectors) {
  const std::uint64_t instance = 100 * kUnit, header = 1 << 19, leaf = 9000 * kUnit;
  const std::vector<SectorCase> cases = {
      {"default",
       {128, true, false},
       {instance, instance + 32, instance + 64, instance + 96, header, header + 32, leaf, leaf + 32}},
      {"half leaf, no header", {64, false, false}, {instance, instance + 32, leaf, leaf + 32}},
      {"descriptor", {64, false, true}, {instance, instance + 32, leaf, leaf, leaf + 32}},
  };
  traces::RayGroup group;
  group.rays.resize(1);
  add_round(group.rays[0], {instance_event(100), leaf_event(9000, LeafOutcome::miss)});
  for (const auto& c : cases) {
    SCOPED_TRACE(c.what);
    BenchOptions options;
    options.rt.memory.traffic = c.traffic;
    RtBench bench(small_header("tlas-tri20"), options);
    bench.run(group);
    std::vector<std::uint64_t> addresses;
    for (const auto& r : bench.requests[0]) {
      addresses.push_back(r.request.address);
      EXPECT_EQ(r.request.region, r.request.address < header ? modules::Region::instance : modules::Region::blas);
    }
    EXPECT_EQ(addresses, c.addresses);
    const std::size_t sectors = c.addresses.size();
    EXPECT_EQ(bench.dones[0].cycle, kFirst + sectors + 2 * (20 + 1) + 6 + 37);
  }
}

// A leaf behind its descriptor: a sector and its latency, the wait, the leaf's two sectors, the unit.
TEST_F(RtUnitTest, ALeafThatWaitsForItsDescriptorTakesTwoRoundTripsAndTheWait) {
  traces::RayGroup group;
  group.rays.resize(1);
  add_round(group.rays[0], {leaf_event(9, LeafOutcome::miss)});
  for (const unsigned wait : {1u, 4u, 30u}) {
    BenchOptions options;
    options.rt.memory.traffic.leaf_descriptor_read = true;
    options.rt.memory.traffic.descriptor_wait = wait;
    RtBench bench(small_header(), options);
    bench.run(group);
    ASSERT_EQ(bench.dones.size(), 1u);
    EXPECT_EQ(bench.dones[0].cycle, kFirst + (1 + 20) + wait + (1 + 20) + 1 + 37);
    ASSERT_EQ(bench.requests[0].size(), 3u);
    EXPECT_EQ(bench.requests[0][0].request.address, 9 * kUnit);
    EXPECT_EQ(bench.requests[0][1].request.address, 9 * kUnit);
    EXPECT_EQ(bench.requests[0][1].cycle, kFirst + (1 + 20) + wait);
    EXPECT_EQ(bench.requests[0][2].request.address, 9 * kUnit + 32);
    EXPECT_EQ(bench.counters().memory.node_visits(), 1u);
    EXPECT_EQ(bench.counters().memory.node_fetches(), 2u);
  }
}

// Lane 0's leaf takes the port two cycles, then lane 1's; lane 0's header is asked for first, and lane 1 joins it.
TEST_F(RtUnitTest, LanesOfDifferentInstancesShareTheHeaderThatTheyWaitFor) {
  constexpr unsigned kWait = 8;
  traces::RayGroup group;
  group.rays.resize(2);
  add_round(group.rays[0], {instance_event(100)});
  add_round(group.rays[1], {instance_event(200)});
  BenchOptions options;
  options.rt.memory.traffic.instance_leaf_bytes = 64;
  options.rt.memory.traffic.header_wait = kWait;
  RtBench bench(small_header("tlas-tri20"), options);
  bench.run(group);
  ASSERT_EQ(bench.requests[0].size(), 6u);
  EXPECT_EQ(bench.requests[0][4].request.address, std::uint64_t{1} << 19);
  EXPECT_EQ(bench.requests[0][4].cycle, kFirst + (2 + 20) + kWait);
  EXPECT_EQ(bench.requests[0][5].request.region, modules::Region::blas);
  EXPECT_EQ(bench.dones[0].cycle, kFirst + (2 + 20) + kWait + (1 + 20) + 1 + 6);
  const auto c = bench.counters().memory;
  EXPECT_EQ(c.fetches[modules::index(modules::Region::instance)], 2u);
  EXPECT_EQ(c.fetches[modules::index(modules::Region::blas)], 1u);
  EXPECT_EQ(c.visits[modules::index(modules::Region::instance)], 2u);
  EXPECT_EQ(c.visits[modules::index(modules::Region::blas)], 0u);
}

/// An L1 that holds every sector.
struct HoldsAll final : modules::read_at_once_if {
  modules::ReadAtOnce read_at_once(Cycle, const modules::MemoryRequest&) override { return modules::ReadAtOnce::hit; }
};

// As the pointer chase, with the L1's hits in place of the memory.
TEST_F(RtUnitTest, AHitCostsWhatTheKeySays) {
  constexpr unsigned kVisits = 7;
  const auto group = chase(1, kVisits, [](unsigned, unsigned i) { return 1 + i; });
  for (const unsigned latency : {0u, 1u, 9u}) {
    HoldsAll l1;
    BenchOptions options;
    options.rt.memory.l1_hit_latency = latency;
    options.l1 = &l1;
    RtBench bench(small_header(), options);
    bench.run(group);
    EXPECT_TRUE(bench.requests[0].empty());
    EXPECT_EQ(bench.dones[0].cycle, kFirst + kVisits * (2 + latency + 1 + 13));
    EXPECT_EQ(bench.counters().memory.node_sectors(), 2 * kVisits);
    EXPECT_EQ(bench.counters().memory.fetch_latency.sum(), kVisits * (2 + latency));
  }
}

TEST_F(RtUnitTest, SphereLeavesGoToTheSphereUnit) {
  traces::RayGroup group;
  group.rays.resize(1);
  add_round(group.rays[0], {leaf_event(9, LeafOutcome::miss)});
  BenchOptions options;
  options.rt.ray_sphere.latency = 50;
  RtBench bench(small_header("ellipsoid"), options);
  bench.run(group);
  EXPECT_EQ(bench.dones[0].cycle, kFirst + 2 + 20 + 1 + 6 + 1 + 50);
  EXPECT_EQ(bench.counters().ray_transform.operations, 1u);
  EXPECT_EQ(bench.counters().ray_sphere.operations, 1u);
  EXPECT_EQ(bench.counters().ray_triangle.operations, 0u);
}

TEST_F(RtUnitTest, CullsTakeASelectionEachAndNoMemory) {
  traces::RayGroup group;
  group.nodes = {node_definition(1, 2, std::vector<NodeKind>(3, NodeKind::internal))};
  group.rays.resize(1);
  add_round(group.rays[0], {internal_event(0, 0b111), cull_event(2, 0), cull_event(3, 0), cull_event(4, 0)});
  RtBench bench(small_header(), {});
  bench.run(group);
  // Culls in three consecutive cycles; the retirement stage runs before the scheduler, so it sees the last one a cycle
  // later.
  EXPECT_EQ(bench.dones[0].cycle, kFirst + (2 + 20 + 1 + 13) + 3);
  EXPECT_EQ(bench.counters().scheduler.culls, 3u);
  EXPECT_EQ(bench.counters().memory.node_visits(), 1u);
  EXPECT_EQ(bench.counters().warp_buffer.max_stack_depth, 3u);
}

TEST_F(RtUnitTest, TheNinthWarpWaitsForAFreeEntry) {
  const auto group = chase(1, 1, [](unsigned, unsigned) { return 1; });
  RtBench bench(small_header(), {});
  for (std::uint16_t slot = 0; slot < 9; ++slot) bench.launch(group, slot);
  bench.run();
  ASSERT_EQ(bench.dones.size(), 9u);
  // Calls are accepted in cycles 1..8; one warp follows the other by two cycles because of the two sectors of a fetch.
  const Cycle alone = kFirst + 2 + 20 + 1 + 13;
  for (unsigned i = 0; i < 8; ++i) EXPECT_EQ(bench.dones[i].cycle, alone + 2 * i) << i;
  // The ninth enters in the cycle in which the first retires and is scheduled in the next.
  EXPECT_EQ(bench.dones[8].cycle, alone + 1 + (2 + 20 + 1 + 13));
  EXPECT_EQ(bench.counters().warp_buffer.occupancy_integral, bench.counters().warp_buffer.warp_latency.sum());
}

TEST_F(RtUnitTest, AQueueOfOneWarpStallsTheScheduler) {
  BenchOptions options;
  options.rt.memory.queue = 32;
  const auto group = chase(32, 1, [](unsigned l, unsigned) { return 1 + l; });
  RtBench bench(small_header(), options);
  bench.launch(group, 0);
  bench.run(group, 1);
  // The second warp's fetches fit only when the queue is empty: after the 64 sectors of the first, issued in cycles
  // kFirst + 1 .. kFirst + 64; the scheduler runs after the issue stage, in the same cycle.
  EXPECT_EQ(bench.dones[1].cycle, kFirst + 64 + 64 + 20 + 1 + 13);
  using modules::Stall;
  EXPECT_EQ(bench.counters().scheduler.stall[static_cast<std::size_t>(Stall::queue_full)], 63u);
}

TEST_F(RtUnitTest, AWarpWithoutEventsRetiresAtOnce) {
  traces::RayGroup group;
  group.rays.resize(2);
  add_round(group.rays[1], {}, true);
  RtBench bench(small_header("tri20", 10), {});
  bench.run(group, 5);
  ASSERT_EQ(bench.dones.size(), 1u);
  EXPECT_EQ(bench.dones[0].cycle, 2u);  // accepted in cycle 1
}

TEST_F(RtUnitTest, BadTracesAreRefusedWithTheirPlace) {
  const std::vector<std::pair<std::vector<Event>, std::string>> cases = {
      {{cull_event(1, 0), cull_event(1, 0)}, "takes a node from an empty stack"},
      {{internal_event(7, 0)}, "visits an internal node that the group does not define"},
      {{take_event(1)}, "replays although checkpointing is off"},
      {{cull_event(1, 1)}, "writes checkpoint entries although checkpointing is off"},
      {{instance_event(1)}, "visits an instance leaf of a monolithic structure"}};
  for (const auto& [events, rule] : cases) {
    traces::RayGroup group;
    group.index = 4;
    group.rays.resize(1);
    add_round(group.rays[0], events);
    RtBench bench(small_header(), {});
    bench.launch(group, 0);
    EXPECT_THAT([&] { bench.run_expecting_error(); },
                ::testing::ThrowsMessage<std::exception>(
                    ::testing::AllOf(::testing::HasSubstr(rule), ::testing::HasSubstr("group 4 lane 0 round 0"))));
  }
}

}  // namespace
}  // namespace grtx::sim
