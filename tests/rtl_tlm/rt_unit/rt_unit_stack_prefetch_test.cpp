// Prefetches from the traversal stack: which requests leave the RT unit, in which cycle, and what they cost.
#include <gmock/gmock.h>

#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "rtl_tlm/rt_unit/rt_bench.h"

namespace grtx::sim {
namespace {

using namespace test;
using modules::StackTrigger;
using ::testing::ElementsAre;

class RtUnitStackPrefetchTest : public modules::SystemCTest {};

constexpr std::uint64_t kUnit = traces::kNodeUnit;
// The first visit is scheduled in cycle 2; two sectors, memory, queue and the unit later its result is there.
constexpr Cycle kBoxResult = 2 + 2 + 20 + 1 + 13;
constexpr Cycle kTriangleResult = 2 + 20 + 1 + 37;

BenchOptions with(unsigned depth, StackTrigger trigger, unsigned pops = 1, bool siblings = false) {
  BenchOptions options;
  options.rt.sibling_prefetch = siblings;
  options.rt.prefetcher.stack = {depth, trigger, pops};
  return options;
}

/// Node 1 with six leaves, all pushed; 11 and 12 are missed, the others culled.
traces::RayGroup six_leaves(unsigned rays = 1) {
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, std::vector<NodeKind>(6, NodeKind::triangle))};
  group.rays.resize(rays);
  for (traces::Ray& ray : group.rays) {
    add_round(ray, {internal_event(0, 0b111111), leaf_event(11, LeafOutcome::miss), leaf_event(12, LeafOutcome::miss),
                    cull_event(10, 0), cull_event(13, 0), cull_event(14, 0), cull_event(15, 0)});
  }
  return group;
}

std::vector<std::uint64_t> nodes(const RtBench& bench) {
  std::vector<std::uint64_t> all;
  for (const auto& r : bench.requests[2]) {
    EXPECT_TRUE(r.request.prefetch);
    if (r.request.address % kUnit == 0) all.push_back(r.request.address / kUnit);
  }
  EXPECT_EQ(bench.requests[2].size(), 2 * all.size());
  return all;
}

TEST_F(RtUnitStackPrefetchTest, APushAsksInTheCycleOfTheTestsResult) {
  const auto group = six_leaves();
  RtBench bench(small_header(), with(3, StackTrigger::push));
  bench.launch(group, 0);
  bench.run();
  EXPECT_THAT(nodes(bench), ElementsAre(12, 10, 13));
  ASSERT_EQ(bench.requests[2].size(), 6u);
  for (Cycle i = 0; i < 6; ++i) EXPECT_EQ(bench.requests[2][i].cycle, kBoxResult + i) << "a sector a cycle";
  const auto c = bench.counters().prefetch;
  EXPECT_EQ(c.stack_looks, 1u);
  EXPECT_EQ(c.stack_nodes, 3u);
  EXPECT_EQ(c.stack_culled, 2u);
  EXPECT_EQ(c.responses, c.sectors);
  EXPECT_EQ(c.triggers, 0u);
}

TEST_F(RtUnitStackPrefetchTest, APopAsksForWhatLiesBelowTheTop) {
  const auto group = six_leaves();
  for (const unsigned pops : {1u, 2u}) {
    SCOPED_TRACE(pops);
    fresh_context();
    RtBench bench(small_header(), with(2, StackTrigger::pop, pops));
    bench.launch(group, 0);
    bench.run();
    if (pops == 1) {
      EXPECT_THAT(nodes(bench), ElementsAre(10, 13, 14, 15));
    } else {
      EXPECT_THAT(nodes(bench), ElementsAre(13, 14, 15));
    }
    EXPECT_EQ(bench.requests[2][0].cycle, kBoxResult + pops * kTriangleResult);
  }
}

TEST_F(RtUnitStackPrefetchTest, LanesThatAskForOneNodeMerge) {
  const auto group = six_leaves(32);
  BenchOptions options = with(2, StackTrigger::push);
  options.rt.ray_box.count = 32;
  RtBench bench(small_header(), options);
  bench.launch(group, 0);
  bench.run();
  EXPECT_THAT(nodes(bench), ElementsAre(12, 10));
  EXPECT_EQ(bench.counters().prefetch.stack_looks, 32u);
  EXPECT_EQ(bench.counters().prefetch.stack_merged, 31u * 2u);
}

TEST_F(RtUnitStackPrefetchTest, AFullQueueDropsAndALaterLookAsksAgain) {
  const auto group = six_leaves();
  BenchOptions options = with(4, StackTrigger::pop);
  options.rt.prefetcher.queue = 2;
  RtBench bench(small_header(), options);
  bench.launch(group, 0);
  bench.run();
  EXPECT_THAT(nodes(bench), ElementsAre(10, 13, 14, 15));
  EXPECT_EQ(bench.counters().prefetch.stack_dropped, 2u);
}

TEST_F(RtUnitStackPrefetchTest, SpilledEntriesAreNotSeen) {
  const auto group = six_leaves();
  for (const unsigned on_chip : {4u, 8u}) {
    SCOPED_TRACE(on_chip);
    fresh_context();
    BenchOptions options = with(6, StackTrigger::pop);
    options.rt.warp_buffer.stack_entries = on_chip;
    RtBench bench(small_header(), options);
    bench.launch(group, 0);
    bench.run();
    // With four on chip 14 and 15 are spilled at once and come back when no other is left.
    if (on_chip == 4) {
      EXPECT_THAT(nodes(bench), ElementsAre(10, 13));
    } else {
      EXPECT_THAT(nodes(bench), ElementsAre(10, 13, 14, 15));
    }
  }
}

TEST_F(RtUnitStackPrefetchTest, BesideSiblingsNothingIsQueuedTwice) {
  const auto group = six_leaves();
  RtBench bench(small_header(), with(5, StackTrigger::push, 1, true));
  bench.launch(group, 0);
  bench.run();
  // The stack's five leave ten cycles long; leaf 11 asks for them again in the cycle of its visit.
  EXPECT_EQ(bench.counters().prefetch.stack_nodes, 5u);
  EXPECT_EQ(bench.counters().prefetch.triggers, 1u);
  EXPECT_EQ(bench.counters().prefetch.nodes + bench.counters().prefetch.merged, 5u);
  EXPECT_GE(bench.counters().prefetch.merged, 4u);
}

TEST_F(RtUnitStackPrefetchTest, OffThereIsNoUnitAndNoSilicon) {
  const auto group = six_leaves();
  RtBench off(small_header(), with(0, StackTrigger::pop));
  EXPECT_FALSE(off.rt().has_prefetcher());
  const auto of = [](const std::vector<modules::Inventory>& all, const std::string& storage) -> std::uint64_t {
    for (const modules::Inventory& inventory : all) {
      for (const modules::Storage& s : inventory.storage) {
        if (s.name == storage) return s.bits;
      }
    }
    return 0;
  };
  EXPECT_EQ(of(off.rt().inventory(), "stack_tops"), 0u);
  fresh_context();
  RtBench on(small_header(), with(4, StackTrigger::pop, 2));
  EXPECT_TRUE(on.rt().has_prefetcher());
  EXPECT_EQ(of(on.rt().inventory(), "stack_tops"), 8u * 32 * 5 * 52);  // five addresses, kinds and marks a lane
  EXPECT_EQ(of(on.rt().inventory(), "pops"), 8u * 32 * 2);
}

TEST(StackPrefetchConfig, IsNoPartOfAMachinesHashWhileItIsOff) {
  EXPECT_EQ(config_hash(load_config("", {})), config_hash(load_config("", {"rt.stack_prefetch.depth=0"})));
  EXPECT_NE(config_hash(load_config("", {})), config_hash(load_config("", {"rt.stack_prefetch.depth=1"})));
  EXPECT_THROW(load_config("", {"rt.stack_prefetch.trigger=both"}), Error);
  EXPECT_THROW(load_config("", {"rt.stack_prefetch.pops=0"}), Error);
}

}  // namespace
}  // namespace grtx::sim
