// SPDX-License-Identifier: Apache-2.0
// The SIMT core's timing to the cycle: one warp, rounds, any-hit batches, contention for a scheduler, stores at the
// end. Formulas are those of docs/model/simt_core.md: a phase with m load sectors that begins in cycle c has its
// loads back in c + m - 1 + R (m > 0), issues from a = max(that + 1, scheduler free), and is ready in a + n + L.
#include <gtest/gtest.h>

#include "grtx/modules/simt/simt_core.h"
#include "modules/simt/simt_bench.h"

namespace grtx::modules {
namespace {

using traces::LeafOutcome;

class SimtTiming : public SystemCTest {};

constexpr Cycle kL = 4;                                                      // default instruction latency
constexpr Cycle phase(Cycle instructions) { return 1 + instructions + kL; }  // no loads, no contention

TEST_F(SimtTiming, GroupWithoutRoundsCostsPrologueEpilogueAndItsPixels) {
  SimtBench bench({});
  const traces::RayGroup group = uniform_group(32, {});
  bench.start(0, group, 1);
  bench.run();
  ASSERT_EQ(bench.ends.size(), 1u);
  const Cycle stores_from = 1 + phase(40) + phase(10);
  // 32 pixels of 16 B are 16 sectors, one per cycle; the end is sent with the last acknowledgement and seen a cycle
  // later.
  EXPECT_EQ(bench.requests.size(), 16u);
  EXPECT_EQ(bench.requests.front().first, stores_from + 1);
  EXPECT_EQ(bench.ends[0].first, stores_from + 15 + bench.memory_latency() + 1);
  EXPECT_TRUE(bench.calls.empty());
  EXPECT_TRUE(bench.core->idle());
}

TEST_F(SimtTiming, ACoreHasOneTo64WarpSlots) {
  ClockDomain clock("clock", 1365.0);
  const MemoryMap map(simt_header(), {1, 64, 0});
  SimtCoreConfig config;
  for (const unsigned slots : {0u, 65u}) {
    config.resident_warps = slots;
    EXPECT_THROW(SimtCore("refused", clock, config, simt_header(), map), Error) << slots;
  }
  for (const unsigned slots : {1u, 64u}) {
    config.resident_warps = slots;
    EXPECT_NO_THROW(SimtCore(("of" + std::to_string(slots)).c_str(), clock, config, simt_header(), map)) << slots;
  }
}

TEST_F(SimtTiming, EmptyGroupHasNothingToStore) {
  SimtBench bench({});
  const traces::RayGroup group;
  bench.start(3, group, 7);
  bench.run();
  ASSERT_EQ(bench.ends.size(), 1u);
  EXPECT_EQ(bench.ends[0].first, 7 + phase(40) + phase(10) + 1);
  EXPECT_EQ(bench.ends[0].second.slot, 3);
}

TEST_F(SimtTiming, RoundsWithoutHitsTakeTraceCallAndBlend) {
  for (unsigned rounds = 1; rounds <= 4; ++rounds) {
    FreshContext();
    SimtBench bench({});
    const traces::RayGroup group = uniform_group(32, std::vector<RoundScript>(rounds));
    bench.start(0, group, 1);
    bench.run();
    ASSERT_EQ(bench.calls.size(), rounds);
    EXPECT_EQ(bench.calls[0].first, 1 + phase(40) + phase(6) + 1);
    // Seen by the RT unit after 1 cycle, traced, TraceDone seen after 1 more.
    const Cycle round = phase(6) + 1 + bench.options.trace_cycles + 1 + phase(10);
    ASSERT_EQ(bench.ends.size(), 1u);
    EXPECT_EQ(bench.ends[0].first, 1 + phase(40) + rounds * round + phase(10) + 15 + bench.memory_latency() + 1);
  }
}

TEST_F(SimtTiming, CheckpointingAddsAnEvictMoveToEveryRound) {
  SimtBench::Options options;
  options.header = checkpointing(options.header);
  SimtBench bench(options);
  const traces::RayGroup group = uniform_group(32, std::vector<RoundScript>(2));
  bench.start(0, group, 1);
  bench.run();
  const Cycle round = phase(8) + phase(6) + 1 + bench.options.trace_cycles + 1 + phase(10);
  ASSERT_EQ(bench.ends.size(), 1u);
  EXPECT_EQ(bench.ends[0].first, 1 + phase(40) + 2 * round + phase(10) + 15 + bench.memory_latency() + 1);
}

TEST_F(SimtTiming, BlendWaitsForItsLoadsThenComputes) {
  SimtBench bench({});
  // All lanes hold two entries; the first is blended, the second only looked at. Gaussian 0 lies in sectors 0 and 1.
  const traces::RayGroup group =
      uniform_group(32, {{{{LeafOutcome::inserted}, {LeafOutcome::inserted}}, {seen(0, true), seen(0, false)}, 0, 0}});
  bench.start(0, group, 1);
  bench.run();
  ASSERT_EQ(bench.any_hits_done.size(), 2u);
  // k-buffer t and id: 4 sectors each and entry; Gaussian record 2; SH record of degree 0 (12 B): 1, first entry only.
  const Cycle sectors = 2 * (8 + 2) + 1;
  const Cycle instructions = 10 + 2 * 24 + 4;
  const Cycle done_seen = bench.any_hits_done[1].first + bench.options.trace_cycles + 1;
  const Cycle blended = done_seen + (sectors - 1 + bench.memory_latency()) + phase(instructions);
  EXPECT_EQ(bench.ends[0].first, blended + phase(10) + 15 + bench.memory_latency() + 1);
}

TEST_F(SimtTiming, AnyHitReadsInsertsAndAnswers) {
  struct Case {
    unsigned before;  // insertions before the measured one
    LeafOutcome outcome;
    unsigned shifts;
    unsigned loads;  // entries read
  };
  const Case cases[] = {
      {0, LeafOutcome::inserted, 0, 0},   // empty buffer: nothing to compare with
      {2, LeafOutcome::inserted, 0, 1},   // compared with the last entry
      {2, LeafOutcome::inserted, 2, 2},   // moved both
      {3, LeafOutcome::inserted, 1, 2},   // moved one, stopped at the next
      {4, LeafOutcome::displaced, 0, 2},  // the last falls out, stops at the one before
      {4, LeafOutcome::displaced, 3, 4},  // to the front
      {4, LeafOutcome::rejected, 0, 1},   // compared with the last entry
      {4, LeafOutcome::ignored, 0, 1},
  };
  for (const Case& c : cases) {
    FreshContext();
    SimtBench bench({});
    RoundScript round;
    for (unsigned i = 0; i < c.before; ++i) round.any_hits.push_back({LeafOutcome::inserted, 0});
    round.any_hits.push_back({c.outcome, c.shifts});
    const traces::RayGroup group = uniform_group(32, {round});
    bench.start(0, group, 1);
    bench.run();
    ASSERT_EQ(bench.batches.size(), c.before + 1);
    const Cycle loads = 8;  // of an entry: two fields of 32 lanes x 4 B
    // Stores of the insertion before are still being sent when this batch arrives; they go first.
    const Cycle seen_in = bench.batches[c.before].first;
    const Cycle stores_before = c.before == 0 ? 0 : 8;
    const Cycle sent_from = c.before == 0 ? seen_in : bench.any_hits_done[c.before - 1].first - 1 + stores_before;
    // Each entry is read once the one before has been looked at, three instructions each.
    Cycle back = c.loads == 0 ? seen_in : sent_from + loads - 1 + bench.memory_latency();
    for (unsigned i = 1; i < c.loads; ++i) back += phase(3) + loads - 1 + bench.memory_latency();
    const unsigned looked_at = c.loads == 0 ? 0 : c.loads - 1;
    EXPECT_EQ(bench.any_hits_done[c.before].first, back + phase(12 + 3 * c.shifts - 3 * looked_at) + 1)
        << "outcome " << static_cast<int>(c.outcome) << " shifts " << c.shifts << " after " << c.before;
  }
}

TEST_F(SimtTiming, TwoBatchesOfOneWarpRunOneAfterTheOther) {
  SimtBench::Options options;
  options.split_batches = true;
  SimtBench bench(options);
  const traces::RayGroup group = uniform_group(32, {{{{LeafOutcome::inserted}}, {}, 0, 0}});
  bench.start(0, group, 1);
  bench.run();
  ASSERT_EQ(bench.any_hits_done.size(), 2u);
  EXPECT_EQ(bench.any_hits_done[0].first, bench.batches[0].first + phase(12) + 1);
  EXPECT_EQ(bench.any_hits_done[1].first, bench.any_hits_done[0].first + phase(12));
  EXPECT_EQ(bench.any_hits_done[0].second.lanes, 0x5555'5555U);
  EXPECT_EQ(bench.any_hits_done[1].second.lanes, 0xAAAA'AAAAU);
}

TEST_F(SimtTiming, WarpsOnOneSchedulerQueueOthersDoNot) {
  SimtBench bench({});
  const traces::RayGroup group = uniform_group(32, std::vector<RoundScript>(1));
  for (const unsigned slot : {0u, 1u, 4u}) bench.start(slot, group, 1);  // slots 0 and 4 share scheduler 0
  bench.run();
  ASSERT_EQ(bench.calls.size(), 3u);
  // Slot 0 and 1: prologue then trace call. Slot 4 issues its prologue behind slot 0's, in cycles 42 to 81; slot 0's
  // trace call becomes ready in 46 and waits for that: it issues in 82 to 87, slot 4's behind it.
  EXPECT_EQ(bench.calls[0].second.slot, 1);
  EXPECT_EQ(bench.calls[0].first, 1 + phase(40) + phase(6) + 1);
  EXPECT_EQ(bench.calls[1].second.slot, 0);
  EXPECT_EQ(bench.calls[1].first, 2 + 40 + 40 + 6 + kL + 1);
  EXPECT_EQ(bench.calls[2].second.slot, 4);
  // Slot 4's prologue is ready in 82 + 4 = 86, one cycle before the scheduler is free in 88.
  EXPECT_EQ(bench.calls[2].first, 2 + 40 + 40 + 6 + 6 + kL + 1);
}

TEST_F(SimtTiming, TraceCallsReadyTogetherLeaveOneACycleInSlotOrder) {
  SimtBench bench({});
  const traces::RayGroup group = uniform_group(32, std::vector<RoundScript>(1));
  for (const unsigned slot : {3u, 1u, 0u, 2u}) bench.start(slot, group, 1);
  bench.run();
  ASSERT_EQ(bench.calls.size(), 4u);
  for (unsigned slot = 0; slot < 4; ++slot) {
    EXPECT_EQ(bench.calls[slot].second.slot, slot);
    EXPECT_EQ(bench.calls[slot].first, 1 + phase(40) + phase(6) + 1 + slot);
  }
}

TEST_F(SimtTiming, AnyHitIssuesBeforeRayGenerationOfTheSameCycle) {
  // Slot 0's any-hit batch is seen in 1 + phase(40) + phase(6) + 1 + 1 = 59. Slot 4's prologue arrives in the same
  // cycle.
  SimtBench bench({});
  const traces::RayGroup with_hit = uniform_group(32, {{{{LeafOutcome::inserted}}, {}, 0, 0}});
  const traces::RayGroup plain = uniform_group(32, std::vector<RoundScript>(1));
  bench.start(4, with_hit, 1);
  bench.start(0, plain, 59);
  bench.run();
  ASSERT_EQ(bench.batches[0].first, 59u);
  EXPECT_EQ(bench.any_hits_done[0].first, 59 + phase(12) + 1);  // lower slot, but ray generation: behind
  EXPECT_EQ(bench.calls[1].first, 60 + 12 + 40 + kL + phase(6) + 1);
}

TEST_F(SimtTiming, AWarpWithPendingStoresDoesNotEnd) {
  SimtBench::Options options;
  options.response_latency = 500;
  SimtBench bench(options);
  const traces::RayGroup group = uniform_group(1, {});
  bench.start(0, group, 1);
  bench.run();
  ASSERT_EQ(bench.requests.size(), 1u);
  EXPECT_EQ(bench.ends[0].first, bench.requests[0].first + 500 + 1);
  EXPECT_EQ(bench.core->counters().warp_cycles[static_cast<std::size_t>(WarpActivity::drain)], 501u);
}

}  // namespace
}  // namespace grtx::modules
