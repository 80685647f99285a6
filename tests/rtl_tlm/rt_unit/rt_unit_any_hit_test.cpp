// SPDX-License-Identifier: Apache-2.0
// Any-hit: a batch fires when all unfinished lanes of a warp have a hit, or on timeout; lanes resume when the shader is
// done.
#include <gmock/gmock.h>

#include "rtl_tlm/rt_unit/rt_bench.h"

namespace grtx::sim {
namespace {

using namespace test;

class RtUnitAnyHitTest : public modules::SystemCTest {};

constexpr Cycle kFirst = 2;               // first scheduling of the first call
constexpr Cycle kLeaf = 2 + 20 + 1 + 37;  // scheduling of a leaf visit to its result
constexpr Cycle kBox = 2 + 20 + 1 + 13;

/// `lanes` rays that hit the same leaf; those in `late` visit an internal node first.
traces::RayGroup hits(unsigned lanes, LaneMask late) {
  traces::RayGroup group;
  group.nodes = {node_definition(1, 2, {NodeKind::triangle})};
  group.rays.resize(lanes);
  for (unsigned l = 0; l < lanes; ++l) {
    std::vector<Event> events;
    if (late >> l & 1) events.push_back(internal_event(0, 1));
    events.push_back(leaf_event(2, LeafOutcome::displaced, 0, l));
    add_round(group.rays[l], events);
  }
  return group;
}

TEST_F(RtUnitAnyHitTest, FiresInTheCycleInWhichTheLastActiveLaneHits) {
  BenchOptions options;
  options.rt.ray_triangle.count = 32;
  options.any_hit_cycles = 10;
  const auto group = hits(32, 0);
  RtBench bench(small_header(), options);
  bench.run(group, 6);
  ASSERT_EQ(bench.batches.size(), 1u);
  EXPECT_EQ(bench.batches[0].cycle, kFirst + kLeaf);
  EXPECT_EQ(bench.batches[0].batch.slot, 6);
  EXPECT_EQ(bench.batches[0].batch.lanes, 0xFFFFFFFFu);
  for (unsigned l = 0; l < 32; ++l) {
    EXPECT_EQ(bench.batches[0].batch.outcome[l], LeafOutcome::displaced);
    EXPECT_EQ(bench.batches[0].batch.shifts[l], l);
  }
  // Batch link 1, shader 10, link back 1; the lanes had no further event and the warp retires in that cycle.
  EXPECT_EQ(bench.dones[0].cycle, kFirst + kLeaf + 1 + 10 + 1);
  EXPECT_EQ(bench.counters().any_hit.timeouts, 0u);
  EXPECT_EQ(bench.counters().scheduler.any_hit_calls, 32u);
}

TEST_F(RtUnitAnyHitTest, FinishedLanesAreNotWaitedFor) {
  BenchOptions options;
  options.rt.any_hit.timeout = 100000;
  auto group = hits(2, 0);
  group.rays[1].rounds.clear();
  group.rays[1].events.clear();
  add_round(group.rays[1], {internal_event(0, 0)});  // misses everything, after the box latency
  RtBench bench(small_header(), options);
  bench.run(group);
  ASSERT_EQ(bench.batches.size(), 1u);
  EXPECT_EQ(bench.batches[0].batch.lanes, 1u);
  // Lane 0 asks first: its two sectors go before lane 1's.
  EXPECT_EQ(bench.batches[0].cycle, kFirst + kLeaf);
}

TEST_F(RtUnitAnyHitTest, TimeoutFiresWithTheLanesThatWait) {
  for (const std::uint64_t timeout : {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{5}, std::uint64_t{30}}) {
    SCOPED_TRACE(timeout);
    BenchOptions options;
    options.rt.any_hit.timeout = timeout;
    options.any_hit_cycles = 3;
    const auto group = hits(4, 0b1000);  // lane 3 hits kBox cycles (and two sectors) later
    RtBench bench(small_header(), options);
    bench.run(group);
    ASSERT_EQ(bench.batches.size(), 2u);
    EXPECT_EQ(bench.batches[0].cycle, kFirst + kLeaf + timeout);
    EXPECT_EQ(bench.batches[0].batch.lanes, 0b0111u);
    EXPECT_EQ(bench.batches[1].batch.lanes, 0b1000u);
    // Lane 3's internal node is fetched after the leaf of lanes 0-2; its own leaf visit follows the box result.
    EXPECT_EQ(bench.batches[1].cycle, kFirst + 2 + kBox + kLeaf);
    EXPECT_EQ(bench.counters().any_hit.timeouts, 1u);
  }
}

TEST_F(RtUnitAnyHitTest, AllActiveBeforeTheTimeoutMakesOneBatch) {
  BenchOptions options;
  options.rt.any_hit.timeout = kBox + 2 + 1;
  const auto group = hits(4, 0b1000);
  RtBench bench(small_header(), options);
  bench.run(group);
  ASSERT_EQ(bench.batches.size(), 1u);
  EXPECT_EQ(bench.batches[0].cycle, kFirst + 2 + kBox + kLeaf);
  EXPECT_EQ(bench.counters().any_hit.wait_cycles, kBox + 2);
}

TEST_F(RtUnitAnyHitTest, AWarpHasOneBatchAtTheShader) {
  BenchOptions options;
  options.rt.any_hit.timeout = 0;
  options.any_hit_cycles = 200;  // longer than lane 3 takes
  const auto group = hits(4, 0b1000);
  RtBench bench(small_header(), options);
  bench.run(group);
  ASSERT_EQ(bench.batches.size(), 2u);
  EXPECT_EQ(bench.batches[1].cycle, bench.batches[0].cycle + 1 + 200 + 1);
}

TEST_F(RtUnitAnyHitTest, OneBatchACycleOldestWarpFirst) {
  BenchOptions options;
  options.rt.any_hit.timeout = 100000;
  options.any_hit_cycles = 1;
  const auto group = hits(1, 0);
  RtBench bench(small_header(), options);
  for (std::uint16_t slot = 0; slot < 4; ++slot) bench.launch(group, slot);
  bench.run();
  ASSERT_EQ(bench.batches.size(), 4u);
  for (unsigned i = 0; i < 4; ++i) {
    EXPECT_EQ(bench.batches[i].batch.slot, i);
    if (i > 0) {
      EXPECT_GT(bench.batches[i].cycle, bench.batches[i - 1].cycle);
    }
  }
}

}  // namespace
}  // namespace grtx::sim
