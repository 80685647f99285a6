// SPDX-License-Identifier: Apache-2.0
// Any-hit unit: the cycle in which each hit is answered, by the fill of its heap, its outcome and what waits before it;
// what falls out of a heap.
#include "grtx/modules/rt_unit/any_hit_unit/any_hit_unit.h"

#include <gtest/gtest.h>

#include "modules/systemc_fixture.h"

namespace grtx::modules {
namespace {

using traces::LeafOutcome;

TEST(HitHeap, TakesTwoToTwelveCyclesWithSixteenHits) {
  const HitHeap heap;
  EXPECT_EQ(heap.insertion(1), 2U);
  EXPECT_EQ(heap.insertion(2), 4U);
  EXPECT_EQ(heap.insertion(3), 4U);
  EXPECT_EQ(heap.insertion(16), 10U);
  EXPECT_EQ(heap.displacement(16), 12U);
  EXPECT_EQ(heap.drain(0), 0U);
  EXPECT_EQ(heap.drain(3), 6U + 6U + 4U);  // of three, two and one
}

class AnyHitUnitTest : public SystemCTest {};

/// An any-hit unit among mocks: one warp whose lanes are at a leaf, and somebody who takes the answers.
struct Bench final : warp_buffer_if, any_hit_client_if {
  using Answers = std::vector<std::pair<Cycle, unsigned>>;  ///< cycle and lane

  Bench(const AnyHitUnit::Config& config, unsigned k, bool evicts, const std::vector<LeafOutcome>& outcomes,
        bool bounded = false)
      : table(1), unit("unit", config, 1, k, evicts, bounded) {
    group.rays.resize(outcomes.size());
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      traces::Event event;
      event.kind_shifts = traces::Event::pack(traces::EventKind::visit_leaf);
      event.detail = static_cast<std::uint8_t>(outcomes[i]);
      group.rays[i].events = {event};
      group.rays[i].rounds.resize(1);
      group.rays[i].rounds[0].event_count = 1;
    }
    unit.warp_buffer.bind(*this);
    unit.client.bind(*this);
    unit.batch.bind(batches);
    unit.done.bind(dones);
    elaborate();
    TraceCall call;
    call.group = &group;
    call.slot = 5;
    call.lanes = static_cast<LaneMask>((LaneMask{1} << outcomes.size()) - 1);
    table.accept(0, call);
    table.move(0, call.lanes, LaneState::ready, LaneState::in_unit);
  }
  /// The lane's hit hides so many entries.
  void hide(LaneId lane, std::uint8_t entries) { table.lane(lane).event.checkpoints = entries; }
  WarpTable& warps() override { return table; }
  void any_hit_done(Cycle, const AnyHitDone& done) override {
    EXPECT_EQ(done.slot, 5U);
    for_each_bit(done.lanes, [&](unsigned lane) { answers.emplace_back(now, lane); });
    table.move(0, done.lanes, LaneState::in_any_hit, LaneState::finished);
  }
  void run_until(Cycle end) {
    for (; now < end; ++now) {
      if (unit.next_due(now - 1) <= now) unit.invoke(now);
    }
  }
  traces::RayGroup group;
  WarpTable table;
  AnyHitUnit unit;
  Link<AnyHitBatch> batches{"batches", 1, 1};
  Link<AnyHitDone> dones{"dones", 1, 1};
  Cycle now = 1;
  Answers answers;
};

AnyHitUnit::Config heaps(unsigned count) {
  AnyHitUnit::Config config;
  config.enabled = true;
  config.count = count;
  return config;
}

TEST_F(AnyHitUnitTest, EachHitTakesItsOwnTimeInTheHeapOfItsLane) {
  Bench bench(heaps(32), 16, false,
              {LeafOutcome::inserted, LeafOutcome::displaced, LeafOutcome::rejected, LeafOutcome::ignored});
  bench.unit.begin_lane(0, 3);
  bench.unit.begin_lane(1, 16);
  for (LaneId id = 0; id < 4; ++id) bench.unit.arrive(10, id);
  EXPECT_EQ(bench.unit.held(), 4U);
  EXPECT_FALSE(bench.unit.idle());
  bench.now = 10;
  bench.run_until(40);
  // The fourth entry of a heap passes two levels; sixteen have four, and the root is one more.
  EXPECT_EQ(bench.answers, (Bench::Answers{{12, 2}, {12, 3}, {16, 0}, {22, 1}}));
  EXPECT_TRUE(bench.unit.idle());
  const AnyHitUnitCounters counters = bench.unit.counters().unit;
  EXPECT_EQ(counters.hits, 4U);
  EXPECT_EQ(counters.answers, 4U);
  EXPECT_EQ(counters.entered, 2U);
  EXPECT_EQ(counters.busy_cycles, 6U + 12 + 2 + 2);
  EXPECT_EQ(counters.wait_cycles, 0U);
}

// Opacity is added to what enters, and what is hidden leaves heaps of 9 and 8 entries, or of one that stays.
TEST_F(AnyHitUnitTest, BoundedByOpacityHitsTakeTheTimeOfWhatTheyHide) {
  Bench bench(heaps(32), 16, false, {LeafOutcome::inserted, LeafOutcome::displaced, LeafOutcome::rejected}, true);
  const HitHeap heap;
  for (LaneId lane = 0; lane < 2; ++lane) bench.hide(lane, 2);
  bench.unit.begin_lane(0, 8);
  bench.unit.begin_lane(1, 16);
  for (LaneId id = 0; id < 3; ++id) bench.unit.arrive(10, id);
  bench.now = 10;
  bench.run_until(80);
  const Cycle inserted = heap.insertion(9) + 2 + heap.displacement(9) + heap.displacement(8);
  const Cycle displaced = heap.displacement(16) + 2 + heap.displacement(16) + heap.displacement(15);
  EXPECT_EQ(inserted, 8U + 2 + 10 + 10);
  EXPECT_EQ(bench.answers, (Bench::Answers{{12, 2}, {10 + inserted, 0}, {10 + displaced, 1}}));
  const AnyHitUnitCounters counters = bench.unit.counters().unit;
  EXPECT_EQ(counters.bounded, 2U);
  EXPECT_EQ(counters.hidden, 4U);
  EXPECT_EQ(counters.busy_cycles, inserted + displaced + 2);
}

TEST_F(AnyHitUnitTest, BoundedByOpacityItHasATableAndSums) {
  const auto bits = [](const AnyHitUnit& unit) {
    std::uint64_t sum = 0;
    for (const Storage& storage : unit.inventory().storage) sum += storage.bits;
    return sum;
  };
  AnyHitUnit without("without", heaps(32), 8, 16, false, false), with("with", heaps(32), 8, 16, false, true);
  EXPECT_EQ(bits(with), bits(without) + 8 * 32 * 32) << "a sum and an end of 16 bits a lane";
  EXPECT_EQ(with.inventory().operators.size(), without.inventory().operators.size() + 4);
}

TEST_F(AnyHitUnitTest, LanesThatShareTheirLogicWaitForEachOther) {
  Bench bench(heaps(2), 16, false,
              {LeafOutcome::inserted, LeafOutcome::inserted, LeafOutcome::rejected, LeafOutcome::rejected});
  for (LaneId id = 0; id < 4; ++id) bench.unit.begin_lane(id, 0);
  for (const LaneId id : {LaneId{0}, LaneId{2}, LaneId{1}}) bench.unit.arrive(10, id);
  bench.unit.arrive(11, 3);
  bench.now = 11;
  bench.run_until(40);
  // Lanes 0 and 2 have logic 0, lanes 1 and 3 logic 1; each takes two cycles.
  EXPECT_EQ(bench.answers, (Bench::Answers{{12, 0}, {12, 1}, {14, 2}, {14, 3}}));
  EXPECT_EQ(bench.unit.counters().unit.wait_cycles, 2U + 1U);
}

TEST_F(AnyHitUnitTest, WithCheckpointingWhatFallsOutIsSentOneACycle) {
  Bench bench(heaps(32), 1, true, {LeafOutcome::rejected, LeafOutcome::displaced, LeafOutcome::inserted});
  bench.unit.begin_lane(0, 1);
  bench.unit.begin_lane(1, 1);
  for (LaneId id = 0; id < 3; ++id) bench.unit.arrive(10, id);
  bench.now = 10;
  std::vector<std::pair<Cycle, LaneMask>> stored;
  for (Cycle end = 11; end < 40; ++end) {
    bench.run_until(end);
    if (const AnyHitBatch* sent = bench.batches.front(end)) {
      EXPECT_EQ(sent->slot, 5U);
      stored.emplace_back(end - 1, sent->lanes);
      bench.batches.pop(end);
    }
  }
  // The rejected hit is done in 12, the displaced one, with a root and no level, in 14; the link takes each at once.
  EXPECT_EQ(stored, (std::vector<std::pair<Cycle, LaneMask>>{{12, 0b001}, {14, 0b010}}));
  EXPECT_EQ(bench.answers, (Bench::Answers{{12, 2}, {12, 0}, {14, 1}}));
}

}  // namespace
}  // namespace grtx::modules
