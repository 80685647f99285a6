// Cooperative lanes: idle lanes fetch and test what lies on a busy lane's stack; the busy ray keeps its order.
#include <gmock/gmock.h>

#include <algorithm>
#include <map>

#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/mode_keys.h"
#include "rtl_tlm/rt_unit/rt_bench.h"

namespace grtx::sim {
namespace {

using namespace test;
using ::testing::ElementsAre;

class RtUnitCooperationTest : public modules::SystemCTest {};

constexpr std::uint64_t kUnit = traces::kNodeUnit;
constexpr Cycle kBoxResult = 2 + 2 + 20 + 1 + 13;  // of the first visit, scheduled in cycle 2
constexpr Cycle kTriangle = 2 + 20 + 1 + 37;       // from a leaf's visit to its result, when its fetch goes out at once

BenchOptions with(unsigned ahead) {
  BenchOptions options;
  options.rt.sibling_prefetch = false;
  options.rt.cooperation.ahead = ahead;
  return options;
}

/// One ray: node 1 with four leaves, all pushed. The first three are missed, the last is culled.
traces::RayGroup four_leaves() {
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, std::vector<NodeKind>(4, NodeKind::triangle))};
  group.rays.resize(1);
  add_round(group.rays[0], {internal_event(0, 0b1111), leaf_event(10, LeafOutcome::miss),
                            leaf_event(11, LeafOutcome::miss), leaf_event(12, LeafOutcome::miss), cull_event(13, 0)});
  return group;
}

/// Cycles in which the first sectors of leaves were asked for, by unit.
std::vector<std::pair<std::uint64_t, Cycle>> leaf_requests(const RtBench& bench) {
  std::vector<std::pair<std::uint64_t, Cycle>> all;
  for (const auto& r : bench.requests[0]) {
    if (r.request.address >= 10 * kUnit && r.request.address % kUnit == 0) {
      all.emplace_back(r.request.address / kUnit, r.cycle);
    }
  }
  return all;
}

TEST_F(RtUnitCooperationTest, IdleLanesTakeWhatLiesBelowTheTopInTheCycleOfTheVisit) {
  const auto group = four_leaves();
  RtBench bench(small_header(), with(2));
  bench.launch(group, 0);
  bench.run();
  // Leaf 10 is the busy lane's own, 11 and 12 go to two idle lanes in the same cycle: two sectors each, one a cycle.
  // 13 is taken when 11's result, two cycles behind that of 10, has been used.
  EXPECT_THAT(leaf_requests(bench),
              ElementsAre(std::pair(10u, kBoxResult + 1), std::pair(11u, kBoxResult + 3),
                          std::pair(12u, kBoxResult + 5), std::pair(13u, kBoxResult + kTriangle + 3)));
  const auto c = bench.counters().cooperation;
  EXPECT_EQ(c.taken, 3u);
  EXPECT_EQ(c.helped + c.waited, 2u);
  EXPECT_EQ(c.wasted, 1u);
}

TEST_F(RtUnitCooperationTest, AnUnfinishedResultIsWaitedForAndAFinishedOneIsFree) {
  const auto group = four_leaves();
  RtBench bench(small_header(), with(2));
  bench.launch(group, 0);
  bench.run();
  // 11 comes two cycles after 10, 12 two after 11: the lane waits for each, handling its next event in the cycle of the
  // result. Without help they take three times kTriangle.
  EXPECT_EQ(bench.counters().cooperation.waited, 2u);
  EXPECT_EQ(bench.counters().scheduler.visits_leaf, 3u);
  EXPECT_EQ(bench.counters().ray_triangle.tests, 4u) << "three visits and one for nothing";
  const Cycle helped = bench.counters().warp_buffer.warp_latency.max();

  fresh_context();
  RtBench alone(small_header(), with(0));
  alone.launch(group, 0);
  alone.run();
  EXPECT_EQ(alone.counters().ray_triangle.tests, 3u);
  // The culled leaf's helper begins when the first result is there and holds the warp as long as it is under way.
  const Cycle unhelped = alone.counters().warp_buffer.warp_latency.max();
  EXPECT_LT(helped, unhelped);
}

TEST_F(RtUnitCooperationTest, AWarpOfOneLaneHasNoHelper) {
  traces::Header header = small_header();
  header.warp_size = 1;
  const auto group = four_leaves();
  RtBench bench(header, with(4));
  bench.launch(group, 0);
  bench.run();
  EXPECT_EQ(bench.counters().cooperation.taken, 0u);
}

TEST_F(RtUnitCooperationTest, BusyLanesHelpNobody) {
  auto group = four_leaves();
  const traces::Ray ray = group.rays[0];
  group.rays.assign(32, ray);
  BenchOptions options = with(4);
  options.rt.ray_box.count = options.rt.ray_triangle.count = 32;
  RtBench bench(small_header(), options);
  bench.launch(group, 0);
  bench.run();
  EXPECT_EQ(bench.counters().cooperation.taken, 0u) << "all lanes go in step";
}

TEST_F(RtUnitCooperationTest, TheTopIsTakenWhileTheShaderRuns) {
  traces::RayGroup group;
  group.nodes = {node_definition(1, 10, std::vector<NodeKind>(2, NodeKind::triangle))};
  group.rays.resize(2);
  add_round(group.rays[0],
            {internal_event(0, 0b11), leaf_event(10, LeafOutcome::inserted), leaf_event(11, LeafOutcome::miss)});
  // The second ray goes on, so that its warp is selected while the first is at the shader.
  add_round(group.rays[1], {internal_event(0, 0b11), leaf_event(10, LeafOutcome::miss), cull_event(11, 0)});
  BenchOptions options = with(1);
  options.any_hit_cycles = 400;
  RtBench bench(small_header(), options);
  bench.launch(group, 0);
  bench.run();
  EXPECT_EQ(bench.counters().cooperation.taken, 2u);
  EXPECT_EQ(bench.counters().cooperation.helped, 1u);
  EXPECT_EQ(bench.counters().cooperation.wasted, 1u);
}

TEST_F(RtUnitCooperationTest, WithoutItThereIsNoUnitAndNoSilicon) {
  const auto names = [](RtBench& bench) {
    std::vector<std::string> all;
    for (const modules::Inventory& inventory : bench.rt().inventory()) all.push_back(inventory.module);
    return all;
  };
  RtBench off(small_header(), with(0));
  EXPECT_THAT(names(off), ::testing::Not(::testing::Contains(::testing::HasSubstr("lane_cooperation"))));
  fresh_context();
  RtBench on(small_header(), with(2));
  const auto inventories = on.rt().inventory();
  const auto unit = std::find_if(inventories.begin(), inventories.end(), [](const modules::Inventory& inventory) {
    return inventory.module.find("lane_cooperation") != std::string::npos;
  });
  ASSERT_NE(unit, inventories.end());
  std::map<std::string, std::uint64_t> parts;
  for (const modules::Storage& s : unit->storage) parts[s.name] += s.bits;
  for (const modules::Operators& o : unit->operators) parts[o.name + std::to_string(o.width)] += o.count;
  const std::map<std::string, std::uint64_t> expected = {
      {"results", 8 * 32 * 2 * (6 * 36 + 10)},  // warps, lanes, results of six children
      {"jobs", 8 * 32 * (5 + 2 + 1)},           // whom, which of its results (0 to 2), whether
      {"taken", 8 * 32 * 2},
      {"arbiter32", 2},
      {"match8", 2 * 32}};
  EXPECT_EQ(parts, expected);
  for (const modules::Storage& s : unit->storage) {
    EXPECT_EQ(s.word_bits, s.name == "results" ? 6u * 36 + 10 : 32u) << s.name;
    EXPECT_EQ(s.read_ports, 1u) << s.name;
    EXPECT_EQ(s.write_ports, 1u) << s.name;
  }
}

TEST_F(RtUnitCooperationTest, OfNarrowTreesARayInAnInstancesSpaceIsTheLargestResult) {
  traces::Header header = small_header();
  header.bvh_width = 2;
  RtBench bench(header, with(1));
  std::vector<std::uint64_t> results;
  for (const modules::Inventory& inventory : bench.rt().inventory()) {
    for (const modules::Storage& s : inventory.storage) {
      if (s.name == "results") results.push_back(s.bits);
    }
  }
  EXPECT_THAT(results, ::testing::ElementsAre(8u * 32 * (6 * 32 + 10)));
}

TEST(CooperationConfig, IsNoPartOfAMachinesHashWhileItIsOffAndRefusedOutsideCycleMode) {
  EXPECT_EQ(config_hash(load_config("", {})), config_hash(load_config("", {"rt.cooperation.ahead=0"})));
  EXPECT_NE(config_hash(load_config("", {})), config_hash(load_config("", {"rt.cooperation.ahead=1"})));
  EXPECT_THROW(load_config("", {"rt.cooperation.ahead=17"}), Error);
  const GpuConfig config = load_config("", {"rt.cooperation.ahead=2"});
  EXPECT_EQ(unmodelled(config, SimulationMode::fast).key, "rt.cooperation.ahead");
  EXPECT_EQ(unmodelled(config, SimulationMode::sampled).key, "rt.cooperation.ahead");
  EXPECT_TRUE(unmodelled(config, SimulationMode::cycle).key.empty());
}

}  // namespace
}  // namespace grtx::sim
