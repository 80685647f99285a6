// SPDX-License-Identifier: Apache-2.0
// The least time of a warp that walks, by the formulas of docs/model/warp_walk.md, and against runs of random machines.
#include "grtx/rtl_tlm/run/walk_chain.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "grtx/base/child_process.h"
#include "grtx/rtl_tlm/run/ray_chain.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "rtl_tlm/plain/random_machine.h"
#include "rtl_tlm/rt_unit/rt_bench.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using namespace test;
using traces::RayGroup;

constexpr Cycle kBox = 13, kTriangle = 37;
constexpr Cycle kFetch = 1 + 1 + 20 + 1 + 1;  ///< to the request, link, L1, second sector, start of the test

GpuConfig walking(unsigned ahead) {
  GpuConfig config;
  config.l1.mshr_merges = 1;  // else another warp's miss may be joined
  config.rt.traversal = modules::TraversalWay::warp;
  config.rt.warp_stack = {64, ahead};
  config.rt.ray_box.count = config.rt.ray_triangle.count = 32;  // a pipeline a lane: no queues
  return config;
}

/// A root with `leaves` leaves that all of `lanes` visit.
RayGroup fan(unsigned lanes, unsigned leaves, LeafOutcome outcome = LeafOutcome::miss, unsigned rounds = 1) {
  RayGroup group;
  group.nodes = {node_definition(1, 10, std::vector<NodeKind>(leaves, NodeKind::triangle))};
  group.rays.resize(lanes);
  for (traces::Ray& ray : group.rays) {
    std::vector<Event> events{internal_event(0, (1u << leaves) - 1)};
    for (std::uint32_t leaf = 0; leaf < leaves; ++leaf) events.push_back(leaf_event(10 + leaf, outcome));
    for (unsigned round = 0; round < rounds; ++round) add_round(ray, events);
  }
  return group;
}

/// Of the traversal alone.
Cycle traversal(const RayGroup& group, const GpuConfig& config) {
  const ChainLatencies latencies(config, small_header());
  return measure_chain(group, latencies).warp - latencies.ray - latencies.round * group.rays[0].rounds.size();
}

// The bound was 70 cycles, whatever the warp had to do, where one warp took 24,526 of 29,720.
TEST(WalkChain, NodesOneAfterTheOtherTakeTheTimeOfEach) {
  EXPECT_EQ(traversal(fan(32, 3), walking(1)), (kFetch + kBox) + 3 * (kFetch + kTriangle));
}

TEST(WalkChain, NodesUnderWayTogetherWaitForTheirParentAlone) {
  EXPECT_EQ(traversal(fan(32, 3), walking(8)), (kFetch + kBox) + (kFetch + kTriangle));
}

TEST(WalkChain, LanesOfANodeShareThePipelines) {
  GpuConfig config = walking(8);
  config.rt.ray_triangle.count = 4;
  config.rt.ray_triangle.interval = 2;
  EXPECT_EQ(traversal(fan(32, 1), config), (kFetch + kBox) + (kFetch + kTriangle) + 7 * 2);
}

TEST(WalkChain, HitsOfALaneAreTakenOneAfterTheOther) {
  GpuConfig config = walking(8);
  config.rt.any_hit_unit.enabled = true;
  config.rt.any_hit_unit.latency = 50;
  config.rt.any_hit_unit.level_latency = 0;
  EXPECT_EQ(traversal(fan(1, 3, LeafOutcome::inserted), config), (kFetch + kBox) + (kFetch + kTriangle) + 3 * 50);
  config.rt.any_hit_unit.count = 1;  // lanes share a heap logic
  EXPECT_EQ(traversal(fan(4, 3, LeafOutcome::inserted), config), (kFetch + kBox) + (kFetch + kTriangle) + 12 * 50);
}

TEST(WalkChain, AnEntryThatAllItsLanesCullTakesNoTime) {
  RayGroup group = fan(2, 1);
  for (traces::Ray& ray : group.rays) ray.events[1] = cull_event(10, 0);
  EXPECT_EQ(traversal(group, walking(8)), kFetch + kBox);
}

TEST(WalkChain, RoundsFollowEachOther) {
  EXPECT_EQ(traversal(fan(8, 2, LeafOutcome::miss, 3), walking(8)), 3 * traversal(fan(8, 2), walking(8)));
}

TEST(WalkChain, ATraceThatAWarpCannotWalkTakesNoTime) {
  RayGroup group = fan(2, 2);
  group.rays[1].events[1] = leaf_event(99, LeafOutcome::miss);  // no child of the root
  EXPECT_EQ(traversal(group, walking(8)), 0u);
}

struct Measured {
  Cycle cycles = 0, ray = 0, warp = 0;
};

Measured simulated(const std::string& path, const GpuConfig& config) {
  ChildProcess child("simulation", [&] {
    const SimulationResult result = simulate(path, config, {});
    const auto& stats = result.document.at("stats");
    nlohmann::ordered_json answer = {result.cycles, stats.at("gpu.bound.longest_ray").at("value"),
                                     stats.at("gpu.bound.longest_warp").at("value")};
    if (!result.violations.empty()) answer = result.violations;
    return answer.dump();
  });
  const auto answer = nlohmann::ordered_json::parse(child.result());
  EXPECT_TRUE(answer.at(0).is_number()) << answer.dump();
  return {answer.at(0).get<Cycle>(), answer.at(1).get<Cycle>(), answer.at(2).get<Cycle>()};
}

// No machine is faster than the bound, whatever its units and memories are.
TEST(WalkChain, IsNeverAboveTheCyclesOfARun) {
  double share = 0.0;
  constexpr unsigned kRuns = 60;
  for (unsigned seed = 0; seed < kRuns; ++seed) {
    Random random(seed);
    traces::testing::RandomOptions options = random_options(random, seed);
    options.two_level = options.checkpoint = false;
    options.objects = options.bins = 0;
    options.capacity = 0;
    options.tracing = traces::Tracing::multi;
    options.any_hit = traces::AnyHit::immediate;
    options.checkpoint_order = traces::CheckpointOrder::fifo;
    if (seed % 3 == 0) options.groups = 1;  // nothing hides the latency of a warp
    GpuConfig config = random_machine(random);
    make_possible(config, options);
    config.rt.traversal = modules::TraversalWay::warp;
    config.rt.warp_buffer.spill = true;
    config.l1.perfect = seed % 2 == 0;  // all hits: as fast as can be
    const traces::testing::TemporaryFile file("walk");
    write_random(file.path(), options, seed % 4 == 0);
    const Measured run = simulated(file.path(), config);
    EXPECT_LE(run.ray, run.warp) << seed;
    EXPECT_LE(run.warp, run.cycles) << seed;
    share += static_cast<double>(run.warp) / static_cast<double>(run.cycles) / kRuns;
  }
  EXPECT_GT(share, 0.15);  // it says something
}

}  // namespace
}  // namespace grtx::sim
