// SPDX-License-Identifier: Apache-2.0
// Warps that walk together: closed forms of docs/model/warp_walk.md, cycle by cycle.
#include <gmock/gmock.h>

#include "grtx/base/error.h"
#include "rtl_tlm/rt_unit/rt_bench.h"

namespace grtx::sim {
namespace {

using namespace test;
using ::testing::ElementsAre;

class WarpWalk : public modules::SystemCTest {
 protected:
  static constexpr Cycle kFirst = 2;    ///< the first scheduling
  static constexpr Cycle kMemory = 20;  ///< from a request to its answer
  static constexpr Cycle kBox = 13, kTriangle = 37;
  static constexpr Cycle kFetch = 2 + kMemory + 1;  ///< of 64 B: from the scheduling to the unit's start

  static BenchOptions walking(unsigned ahead, unsigned entries = 64) {
    BenchOptions options;
    options.memory_latency = kMemory;
    options.rt.traversal = modules::TraversalWay::warp;
    options.rt.warp_stack = {entries, ahead};
    options.rt.ray_box.count = options.rt.ray_triangle.count = 32;  // a pipeline a lane: no queues
    return options;
  }
  /// A root with `leaves` leaves that all of `lanes` visit, and find `outcome`.
  static traces::RayGroup fan(unsigned lanes, unsigned leaves, LeafOutcome outcome = LeafOutcome::miss) {
    traces::RayGroup group;
    group.nodes = {node_definition(1, 10, std::vector<NodeKind>(leaves, NodeKind::triangle))};
    group.rays.resize(lanes);
    for (traces::Ray& ray : group.rays) {
      std::vector<Event> events{internal_event(0, (1u << leaves) - 1)};
      for (std::uint32_t leaf = 0; leaf < leaves; ++leaf) events.push_back(leaf_event(10 + leaf, outcome));
      add_round(ray, events);
    }
    return group;
  }
};

TEST_F(WarpWalk, ANodeIsFetchedOnceForAllItsLanesAndTestedForEach) {
  const auto group = fan(32, 2);
  RtBench bench(small_header(), walking(1));
  bench.run(group);
  const auto c = bench.counters();
  EXPECT_EQ(c.memory.node_visits(), 32u * 3);
  EXPECT_EQ(c.memory.node_fetches(), 3u);
  EXPECT_EQ(c.ray_box.tests, 32u);
  EXPECT_EQ(c.ray_triangle.tests, 64u);
  EXPECT_EQ(c.scheduler.walk.entries, 3u);
  EXPECT_EQ(c.scheduler.lanes_handled, 96u);
  EXPECT_EQ(c.scheduler.walk.most_waiting, 2u);
}

TEST_F(WarpWalk, OneEntryAtATimeWaitsForEachNode) {
  const auto group = fan(32, 3);
  RtBench bench(small_header(), walking(1));
  bench.run(group);
  ASSERT_EQ(bench.dones.size(), 1u);
  // A result makes the next entry startable in its cycle; the root keeps the slot until its third child is written.
  EXPECT_EQ(bench.dones[0].cycle, kFirst + (kFetch + kBox) + 2 + 3 * (kFetch + kTriangle));
}

// All children of all nodes that were done in a cycle came into the stack at once.
TEST_F(WarpWalk, ChildrenWaitForThePortThatWritesThem) {
  const auto group = fan(32, 5);
  const auto end = [&](unsigned ports) {
    BenchOptions options = walking(1);
    options.rt.warp_stack.write_ports = ports;
    RtBench bench(small_header(), options);
    bench.run(group);
    return bench.dones[0].cycle;
  };
  const Cycle unlimited = kFirst + (kFetch + kBox) + 5 * (kFetch + kTriangle);
  EXPECT_EQ(end(0), unlimited);
  EXPECT_EQ(end(1), unlimited + 4);
  EXPECT_EQ(end(2), unlimited + 2);
}

// Queues of tests had no end: 128 nodes of 32 lanes are 4,096 tests.
TEST_F(WarpWalk, TestsBeyondTheQueueWaitInTheirNodes) {
  const auto group = fan(32, 2);
  BenchOptions options = walking(8);
  options.rt.warp_stack.tests = 32;
  RtBench bench(small_header(), options);
  bench.run(group);
  // The second leaf's tests are queued with the results of the first's, and start a cycle later.
  EXPECT_EQ(bench.dones[0].cycle, kFirst + (kFetch + kBox) + (kFetch + kTriangle) + 1 + kTriangle);
  EXPECT_EQ(bench.counters().ray_triangle.queue_max, 32u);
}

TEST_F(WarpWalk, EntriesThatRunAheadShareTheLatency) {
  const auto group = fan(32, 3);
  RtBench bench(small_header(), walking(8));
  bench.run(group);
  // One entry starts a cycle, and the port takes a sector a cycle: the third leaf's are sent behind four others.
  EXPECT_EQ(bench.dones[0].cycle, kFirst + (kFetch + kBox) + (kFetch + kTriangle) + 4);
}

TEST_F(WarpWalk, LanesThatCullAnEntryAreTestedInVainAndAnEntryOfThemAllIsDropped) {
  traces::RayGroup group = fan(2, 2);
  group.rays[0].events[1] = cull_event(10, 0);  // the other lane visits it
  group.rays[0].events[2] = cull_event(11, 0);
  group.rays[1].events[2] = cull_event(11, 0);
  RtBench bench(small_header(), walking(8));
  bench.run(group);
  const auto c = bench.counters();
  EXPECT_EQ(c.memory.node_visits(), 3u);
  EXPECT_EQ(c.ray_triangle.tests, 2u);
  EXPECT_EQ(c.scheduler.walk.in_vain, 1u);
  EXPECT_EQ(c.scheduler.walk.dropped, 1u);
  EXPECT_EQ(c.scheduler.culls, 3u);
}

TEST_F(WarpWalk, HitsOfALaneAreAnsweredOneByOneWhileOthersAreFound) {
  const auto group = fan(1, 3, LeafOutcome::inserted);
  BenchOptions options = walking(8);
  options.rt.any_hit_unit.enabled = true;
  options.rt.any_hit_unit.latency = 50;
  options.rt.any_hit_unit.level_latency = 0;
  RtBench bench(small_header(), options);
  bench.run(group);
  // The first hit comes with the first leaf; the heap then takes three times 50 cycles.
  EXPECT_EQ(bench.dones[0].cycle, kFirst + (kFetch + kBox) + (kFetch + kTriangle) + 3 * 50);
  EXPECT_EQ(bench.counters().any_hit.unit.hits, 3u);
}

TEST_F(WarpWalk, ALeafThatFindsNoRoomForTheHitsOfItsLanesWaitsUntilSomeAreAnswered) {
  const auto group = fan(32, 5, LeafOutcome::inserted);  // four leaves take all 128 places
  BenchOptions options = walking(8);
  options.rt.any_hit_unit.enabled = true;
  options.rt.any_hit_unit.latency = 50;
  options.rt.any_hit_unit.level_latency = 0;
  RtBench bench(small_header(), options);
  bench.run(group);
  // Its leaf starts with the first answer: its test is over before the heap has taken the other three hits.
  EXPECT_EQ(bench.dones[0].cycle, kFirst + (kFetch + kBox) + (kFetch + kTriangle) + 5 * 50);
  EXPECT_EQ(bench.requests[0][10].cycle, kFirst + (kFetch + kBox) + (kFetch + kTriangle) + 50 + 1);
}

TEST_F(WarpWalk, HitsOfAWarpAreAnsweredByTheShaderInBatches) {
  const auto group = fan(4, 2, LeafOutcome::inserted);
  RtBench bench(small_header(), walking(8));
  bench.run(group);
  ASSERT_EQ(bench.batches.size(), 2u);
  for (const auto& sent : bench.batches) EXPECT_EQ(sent.batch.lanes, 0b1111u);
  // All active lanes have a hit: the batch goes in the cycle of the result; the second one with the first's answer.
  EXPECT_EQ(bench.batches[0].cycle, kFirst + (kFetch + kBox) + (kFetch + kTriangle));
  EXPECT_EQ(bench.batches[1].cycle, bench.batches[0].cycle + 1 + 10 + 1);
}

TEST_F(WarpWalk, EntriesBeyondTheStackGoToMemoryAndComeBack) {
  // A root with three nodes of six leaves each: the second node's leaves find no room among the first's.
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, std::vector<NodeKind>(3, NodeKind::internal))};
  std::vector<Event> events{internal_event(0, 0b111)};
  for (std::uint32_t n = 0; n < 3; ++n) {
    group.nodes.push_back(node_definition(10 + n, 100 + 10 * n, std::vector<NodeKind>(6, NodeKind::triangle)));
    events.push_back(internal_event(1 + n, 0b111111));
    for (std::uint32_t leaf = 0; leaf < 6; ++leaf) events.push_back(leaf_event(100 + 10 * n + leaf, LeafOutcome::miss));
  }
  group.rays.resize(1);
  add_round(group.rays[0], events);
  RtBench bench(small_header(), walking(3, 10));
  bench.run(group);
  const auto c = bench.counters();
  EXPECT_GT(c.stack.spills, 0u);
  EXPECT_EQ(c.stack.fills, c.stack.spills);
  EXPECT_EQ(c.scheduler.visits_leaf, 18u);
  EXPECT_EQ(bench.requests[3][0].request.address, bench.map().stack_sector(bench.map().ray_slot(0, 0, 0), 0));
  RtBench roomy(small_header(), walking(3, 64));
  roomy.run(group);
  EXPECT_EQ(roomy.counters().stack.spills, 0u);
  EXPECT_GT(bench.dones[0].cycle, roomy.dones[0].cycle);
}

// The RT scheduler refused such a trace, the walk took it.
TEST_F(WarpWalk, EntriesInATraceWithoutCheckpointingAreRefused) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "an exception crosses SystemC's stacks: see rt_unit_damaged_trace_test.cpp";
#endif
  traces::RayGroup group = fan(2, 2);
  group.rays[1].events[2] = cull_event(11, 1);
  RtBench bench(small_header(), walking(8));
  try {
    bench.run(group);
    ADD_FAILURE() << "the trace was taken";
  } catch (const sc_core::sc_report& report) {
    EXPECT_STREQ(report.get_msg(),
                 "trace: group 0 lane 1 round 0: writes checkpoint entries although checkpointing is off");
  }
}

// Design walk has a stack of 96 entries: sixteen nodes under way give more children than 64 hold.
TEST_F(WarpWalk, AStackOf96HoldsWhatOneOf64Spills) {
  // A root with six nodes of six nodes of five leaves each, all visited by one lane.
  constexpr std::uint32_t kNode = 100, kInner = 1000, kLeaf = 10000;
  const std::vector<NodeKind> nodes(6, NodeKind::internal), leaves(5, NodeKind::triangle);
  traces::RayGroup group;
  group.nodes = {node_definition(1, kNode, nodes)};
  std::vector<Event> events{internal_event(0, 0b111111)};
  const auto visit = [&](std::uint32_t address, std::uint32_t child, const std::vector<NodeKind>& kinds) {
    events.push_back(internal_event(static_cast<std::uint32_t>(group.nodes.size()), (1u << kinds.size()) - 1));
    group.nodes.push_back(node_definition(address, child, kinds));
  };
  for (std::uint32_t n = 0; n < 6; ++n) {
    visit(kNode + n, kInner + 10 * n, nodes);
    for (std::uint32_t i = 0; i < 6; ++i) {
      const std::uint32_t base = kLeaf + 100 * n + 10 * i;
      visit(kInner + 10 * n + i, base, leaves);
      for (std::uint32_t leaf = 0; leaf < 5; ++leaf) events.push_back(leaf_event(base + leaf, LeafOutcome::miss));
    }
  }
  group.rays.resize(1);
  add_round(group.rays[0], events);
  struct Run {
    std::uint64_t spills, most_waiting;
    Cycle end;
  };
  const auto run = [&](unsigned entries) {
    RtBench bench(small_header(), walking(16, entries));
    bench.run(group);
    EXPECT_EQ(bench.counters().scheduler.visits_leaf, 180u);
    EXPECT_EQ(bench.counters().stack.fills, bench.counters().stack.spills);
    return Run{bench.counters().stack.spills, bench.counters().scheduler.walk.most_waiting, bench.dones[0].cycle};
  };
  const Run small = run(64), walk = run(96), endless = run(1024);
  EXPECT_GT(endless.most_waiting, 64u);
  EXPECT_LE(endless.most_waiting, 96u);
  EXPECT_GT(small.spills, 0u);
  EXPECT_EQ(walk.spills, 0u);
  EXPECT_EQ(walk.end, endless.end);
  EXPECT_GT(small.end, walk.end);
}

TEST_F(WarpWalk, TracesThatWarpsCannotWalkAreRefusedByTheKey) {
  const auto refused = [](const traces::Header& header, BenchOptions options) {
    try {
      RtBench bench(header, options);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("not at all");
  };
  EXPECT_THAT(refused(small_header("tlas-tri20"), walking(8)), ::testing::HasSubstr("rt.traversal: warp is for"));
  EXPECT_THAT(refused(small_header("tri20", 64), walking(8)), ::testing::HasSubstr("rt.traversal: warp is for"));
  traces::Header delayed = small_header();
  delayed.any_hit = traces::AnyHit::delayed;
  EXPECT_THAT(refused(delayed, walking(8)), ::testing::HasSubstr("rt.traversal: warp is for"));
}

}  // namespace
}  // namespace grtx::sim
