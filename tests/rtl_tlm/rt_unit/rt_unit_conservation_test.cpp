// On random legal traces: every event is executed once, every request is answered, lane traffic adds up; and nothing
// depends on the construction order, on idle skip, or on how modules are timed.
#include <gmock/gmock.h>

#include "rtl_tlm/rt_unit/rt_bench.h"
#include "traces/random_group.h"

namespace grtx::sim {
namespace {

using namespace test;
using traces::testing::random_trace;
using traces::testing::RandomOptions;

class RtUnitConservationTest : public modules::SystemCTest {};

struct Expected {
  std::uint64_t internal = 0, instance = 0, leaf = 0, culls = 0, takes = 0, forwards = 0, any_hit = 0, written = 0;
  std::uint64_t calls = 0;
};

Expected count(const std::vector<traces::RayGroup>& groups) {
  Expected e;
  for (const auto& group : groups) {
    std::size_t rounds = 0;
    for (const auto& ray : group.rays) {
      rounds = std::max(rounds, ray.rounds.size());
      for (const auto& event : ray.events) {
        switch (event.kind()) {
          case EventKind::visit_internal:
            ++e.internal;
            break;
          case EventKind::visit_instance:
            ++e.instance;
            break;
          case EventKind::visit_leaf:
            ++e.leaf;
            if (calls_any_hit(event.outcome())) ++e.any_hit;
            break;
          case EventKind::cull:
            ++e.culls;
            break;
          case EventKind::replay_take:
            ++e.takes;
            break;
          case EventKind::replay_forward:
            ++e.forwards;
            break;
        }
        e.written += static_cast<unsigned>(std::popcount(unsigned{event.checkpoints}));
      }
    }
    e.calls += rounds;
  }
  return e;
}

void launch_all(RtBench& bench, const std::vector<traces::RayGroup>& groups) {
  for (std::size_t g = 0; g < groups.size(); ++g) {
    bool any = false;
    for (const auto& ray : groups[g].rays) any = any || !ray.rounds.empty();
    if (any) bench.launch(groups[g], static_cast<std::uint16_t>(g));
  }
}

void expect_conserved(const RandomOptions& random, const BenchOptions& options) {
  SCOPED_TRACE(traces::testing::describe(random));
  fresh_context();
  const auto trace = random_trace(random);
  RtBench bench(trace.header, options);
  launch_all(bench, trace.groups);
  bench.run();
  const Expected e = count(trace.groups);
  const auto c = bench.counters();
  EXPECT_EQ(c.scheduler.visits_internal, e.internal);
  EXPECT_EQ(c.scheduler.visits_instance, e.instance);
  EXPECT_EQ(c.scheduler.visits_leaf, e.leaf);
  EXPECT_EQ(c.scheduler.culls, e.culls);
  EXPECT_EQ(c.scheduler.replay_takes, e.takes);
  EXPECT_EQ(c.scheduler.replay_forwards, e.forwards);
  EXPECT_EQ(c.scheduler.any_hit_calls, e.any_hit);
  EXPECT_EQ(c.any_hit.lanes, e.any_hit);
  EXPECT_EQ(c.any_hit.batches, bench.batches.size());
  EXPECT_EQ(c.warp_buffer.calls, e.calls);
  EXPECT_EQ(bench.dones.size(), e.calls);
  EXPECT_EQ(c.memory.node_visits(), e.internal + e.instance + e.leaf);
  EXPECT_LE(c.memory.node_fetches(), c.memory.node_visits());
  EXPECT_EQ(c.memory.fetch_latency.count(), c.memory.node_fetches());
  EXPECT_EQ(c.memory.node_sectors(), bench.requests[0].size());
  EXPECT_EQ(c.ray_box.operations, e.internal);
  EXPECT_EQ(c.ray_transform.operations, e.instance);
  EXPECT_EQ(c.ray_triangle.operations, e.leaf);
  EXPECT_EQ(c.checkpoint.entries_written, e.written);
  EXPECT_EQ(c.checkpoint.entries_read, e.takes + e.forwards);
  EXPECT_EQ(c.checkpoint.acknowledged, c.checkpoint.sectors_written);
  EXPECT_EQ(c.checkpoint.returned, c.checkpoint.sectors_read);
  EXPECT_EQ(c.checkpoint.sectors_written + c.checkpoint.sectors_read, bench.requests[1].size());
  EXPECT_EQ(c.prefetch.responses, c.prefetch.sectors);
  EXPECT_EQ(c.warp_buffer.occupancy_integral, c.warp_buffer.warp_latency.sum());
  // Every cycle up to the last retirement is a selection or has one stall reason.
  std::uint64_t cycles = c.scheduler.selections;
  for (const auto s : c.scheduler.stall) cycles += s;
  if (!bench.dones.empty()) {
    EXPECT_EQ(cycles, bench.end_of_counts());
  }
}

TEST_F(RtUnitConservationTest, EveryKindOfTrace) {
  for (auto random : traces::testing::all_random_options()) {
    random.groups = 1;
    expect_conserved(random, {});
  }
}

TEST_F(RtUnitConservationTest, FullWarpsUnderEveryPolicyAndTightResources) {
  std::uint32_t seed = 900;
  for (const char* policy : {"oldest_first", "round_robin", "greedy_then_oldest"}) {
    for (const bool tight : {false, true}) {
      RandomOptions random;
      random.seed = ++seed;
      random.warp_size = 32;
      random.groups = 6;
      random.two_level = tight;
      random.k = 4;
      BenchOptions options;
      options.rt.scheduler.policy = policy;
      options.rt.memory.merge_in_flight = !tight;
      if (tight) {
        options.rt.warp_buffer.entries = 2;
        options.rt.memory.queue = 32;
        options.rt.ray_box = options.rt.ray_triangle = options.rt.ray_transform = {1, 9, 3};
        options.rt.box_op_per_child = true;
        options.rt.checkpoint.lanes = 1;
        options.rt.checkpoint.write_queue = 2;
        options.rt.checkpoint.write_combine = options.rt.checkpoint.read_buffer = true;
        options.rt.prefetcher = {1, 2};
        options.rt.any_hit.timeout = 3;
      }
      expect_conserved(random, options);
    }
  }
}

TEST_F(RtUnitConservationTest, StatisticsDoNotDependOnConstructionOrderOrIdleSkip) {
  for (const bool two_level : {false, true}) {
    RandomOptions random;
    random.seed = 77;
    random.warp_size = 32;
    random.groups = 10;
    random.two_level = two_level;
    const auto trace = random_trace(random);
    std::string reference;
    for (const bool idle_skip : {true, false}) {
      for (const unsigned order : {0u, 1u, 2u}) {
        fresh_context();
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
      fresh_context();
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
