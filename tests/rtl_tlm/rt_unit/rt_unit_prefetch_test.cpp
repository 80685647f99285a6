// SPDX-License-Identifier: Apache-2.0
// Sibling prefetch: the first demand fetch of a child leaf asks for the hit siblings, once per internal visit.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "rtl_tlm/rt_unit/rt_bench.h"

namespace grtx::sim {
namespace {

using namespace test;
using ::testing::ElementsAre;

class RtUnitPrefetchTest : public modules::SystemCTest {};

constexpr std::uint64_t kNodeBytes = traces::kNodeUnit;

std::vector<std::uint64_t> prefetched(const RtBench& bench) {
  std::vector<std::uint64_t> nodes;
  for (const auto& r : bench.requests[2]) {
    EXPECT_TRUE(r.request.prefetch);
    if (r.request.address % kNodeBytes == 0) nodes.push_back(r.request.address / kNodeBytes);
  }
  EXPECT_EQ(bench.requests[2].size(), 2 * nodes.size());
  return nodes;
}

// Node 1 has children at units 10..14; 12 is internal. Hit: 10, 11, 12, 14; visited 11 first, then the others.
traces::RayGroup family() {
  traces::RayGroup group;
  group.nodes = {
      node_definition(
          1, 10, {NodeKind::triangle, NodeKind::triangle, NodeKind::internal, NodeKind::triangle, NodeKind::triangle}),
      node_definition(12, 30, {NodeKind::triangle})};
  group.rays.resize(1);
  add_round(group.rays[0], {internal_event(0, 0b10111), leaf_event(11, LeafOutcome::miss), internal_event(1, 0),
                            leaf_event(10, LeafOutcome::miss), leaf_event(14, LeafOutcome::miss)});
  return group;
}

TEST_F(RtUnitPrefetchTest, OnlyHitSiblingsAndOnlyOnce) {
  const auto group = family();
  RtBench bench(small_header(), {});
  bench.run(group);
  EXPECT_THAT(prefetched(bench), ElementsAre(10, 12, 14));
  const auto c = bench.counters().prefetch;
  EXPECT_EQ(c.triggers, 1u);
  EXPECT_EQ(c.nodes, 3u);
  EXPECT_EQ(c.responses, c.sectors);
  // Triggered in the cycle in which leaf 11 is scheduled: 2 + 20 + 1 + 13 after the first; sent from the next cycle on.
  EXPECT_EQ(bench.requests[2][0].cycle, 2u + 36u + 1u);
}

TEST_F(RtUnitPrefetchTest, InternalSiblingsDoNotTrigger) {
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, {NodeKind::triangle, NodeKind::internal}),
                 node_definition(11, 30, {NodeKind::triangle})};
  group.rays.resize(1);
  add_round(group.rays[0], {internal_event(0, 0b11), internal_event(1, 0), cull_event(10, 0)});
  RtBench bench(small_header(), {});
  bench.run(group);
  EXPECT_TRUE(bench.requests[2].empty());
}

TEST_F(RtUnitPrefetchTest, SwitchedOffThereIsNoUnit) {
  BenchOptions options;
  options.rt.sibling_prefetch = false;
  const auto group = family();
  RtBench bench(small_header(), options);
  EXPECT_FALSE(bench.rt().has_prefetcher());
  bench.run(group);
  EXPECT_TRUE(bench.requests[2].empty());
}

TEST_F(RtUnitPrefetchTest, LanesOfAWarpMergeTheirPrefetches) {
  auto group = family();
  const auto ray = group.rays[0];
  group.rays.assign(32, ray);
  BenchOptions options;
  options.rt.ray_box.count = 32;
  RtBench bench(small_header(), options);
  bench.run(group);
  EXPECT_THAT(prefetched(bench), ElementsAre(10, 12, 14));
  EXPECT_EQ(bench.counters().prefetch.triggers, 32u);
  EXPECT_EQ(bench.counters().prefetch.merged, 31u * 3u);
}

TEST_F(RtUnitPrefetchTest, InstanceLeavesAreFollowedByTheirSizeInTheImage) {
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, {NodeKind::instance, NodeKind::instance, NodeKind::instance})};
  group.rays.resize(1);
  // BLAS root is a leaf at unit 9000; three instances of two units each.
  add_round(group.rays[0], {internal_event(0, 0b111), instance_event(12), leaf_event(9000, LeafOutcome::miss),
                            cull_event(10, 0), cull_event(14, 0)});
  BenchOptions options;
  options.rt.memory.traffic.instance_leaf_bytes = 64;
  RtBench bench(small_header("tlas-tri20"), options);
  bench.run(group);
  EXPECT_THAT(prefetched(bench), ElementsAre(10, 14));
}

TEST_F(RtUnitPrefetchTest, AnInstanceLeafThatIsReadForAReplayedBlasNodeTriggersToo) {
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, {NodeKind::instance, NodeKind::instance})};
  group.rays.resize(1);
  group.nodes.push_back(node_definition(2, 1, {NodeKind::internal}));
  add_round(group.rays[0], {internal_event(1, 0b1, 0b1), cull_event(1, 1)});
  // Two entries: one names node 1, the other BLAS node 9000 below leaf 10.
  add_round(group.rays[0],
            {take_event(1), internal_event(0, 0b11), cull_event(12, 0), cull_event(10, 0), take_event(9000),
             instance_event(10, 1), leaf_event(9000, LeafOutcome::miss)},
            true);
  BenchOptions options;
  options.rt.memory.traffic.instance_leaf_bytes = 64;
  RtBench bench(small_header("tlas-tri20", 64), options);
  bench.run(group);
  EXPECT_THAT(prefetched(bench), ElementsAre(12));
}

TEST_F(RtUnitPrefetchTest, AReplayedLeafBringsThoseThatWereCheckpointedWithIt) {
  // Node 1 pushes 10 and checkpoints 11, 13 and 14; the next round takes 13 and 14 and forwards 11.
  traces::RayGroup group = family();
  group.rays[0] = {};
  add_round(group.rays[0], {internal_event(0, 0b00001, 0b11010), leaf_event(10, LeafOutcome::miss)});
  add_round(group.rays[0],
            {forward_event(11, 1), take_event(13), leaf_event(13, LeafOutcome::miss), take_event(14),
             leaf_event(14, LeafOutcome::miss)},
            true);
  for (const auto& [replayed, entry_bytes] : {std::pair(true, 20u), std::pair(false, 20u), std::pair(true, 8u)}) {
    SCOPED_TRACE(fmt::format("{} {}", replayed, entry_bytes));
    BenchOptions options;
    options.rt.prefetcher.replayed = replayed;
    options.rt.checkpoint.entry_bytes = entry_bytes;
    RtBench bench(small_header("tri20", 64), options);
    bench.run(group);
    if (replayed && entry_bytes == 20) {
      EXPECT_THAT(prefetched(bench), ElementsAre(11, 14));
      EXPECT_EQ(bench.counters().prefetch.replayed, 1u);
    } else {
      EXPECT_TRUE(bench.requests[2].empty());
    }
  }
}

TEST_F(RtUnitPrefetchTest, AFullQueueDrops) {
  BenchOptions options;
  options.rt.prefetcher.queue = 2;
  const auto group = family();
  RtBench bench(small_header(), options);
  bench.run(group);
  EXPECT_THAT(prefetched(bench), ElementsAre(10, 12));
  EXPECT_EQ(bench.counters().prefetch.dropped, 1u);
}

}  // namespace
}  // namespace grtx::sim
