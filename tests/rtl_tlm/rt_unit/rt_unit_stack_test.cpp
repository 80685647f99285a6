// SPDX-License-Identifier: Apache-2.0
// Short stacks of the RT unit: which sectors move, when, and what that costs a lane. docs/model/stack_unit.md.
#include <gmock/gmock.h>

#include "grtx/modules/rt_unit/stack/stack_unit.h"
#include "rtl_tlm/rt_unit/rt_bench.h"

namespace grtx::sim {
namespace {

using namespace test;
using ::testing::ElementsAre;

constexpr unsigned kMemory = 20;  ///< cycles from issue to response

class RtUnitStack : public modules::SystemCTest {
 protected:
  struct Move {
    bool write;
    std::uint64_t sector;  ///< of the ray's stack area
    friend bool operator==(const Move&, const Move&) = default;
  };
  struct Run {
    Cycle done;
    std::vector<Move> moves;
    std::vector<Cycle> sent;
    modules::StackUnit::Counters counters;
  };

  static Run run(const traces::Header& header, const traces::RayGroup& group, unsigned stack_entries) {
    BenchOptions options;
    options.memory_latency = kMemory;
    options.rt.warp_buffer.spill = stack_entries != 0;
    if (stack_entries != 0) options.rt.warp_buffer.stack_entries = stack_entries;
    RtBench bench(header, options);
    bench.run(group, 3);
    Run result{bench.dones.at(0).cycle, {}, {}, bench.counters().stack};
    for (const RtBench::Request& r : bench.requests[3]) {
      std::uint64_t sector = 0;
      while (bench.map().stack_sector(bench.map().ray_slot(0, 3, 0), sector) != r.request.address) ++sector;
      result.moves.push_back({r.request.write, sector});
      result.sent.push_back(r.cycle);
      EXPECT_EQ(r.request.region, modules::Region::stack);
    }
    return result;
  }

  /// One ray whose root pushes `children` leaves, with these events behind the root's.
  static traces::RayGroup fan(unsigned children, const std::vector<Event>& events) {
    traces::RayGroup group;
    group.nodes.push_back(node_definition(1, 2, std::vector<NodeKind>(children, NodeKind::triangle)));
    std::vector<Event> all = {internal_event(0, (1U << children) - 1)};
    all.insert(all.end(), events.begin(), events.end());
    group.rays.resize(1);
    add_round(group.rays[0], all);
    return group;
  }
  static std::vector<Event> leaves(unsigned count) {
    std::vector<Event> events;
    for (unsigned i = 0; i < count; ++i) events.push_back(leaf_event(2 + i, LeafOutcome::miss));
    return events;
  }
};

TEST_F(RtUnitStack, NothingMovesWhileTheStackFits) {
  const auto group = fan(5, leaves(5));
  const Run fits = run(small_header(), group, 5);
  EXPECT_EQ(fits.moves.size(), 0U);
  EXPECT_EQ(fits.done, run(small_header(), group, 0).done);
}

struct Case {
  unsigned children;
  unsigned stack_entries;
  unsigned pairs;  ///< ceil((children - stack_entries) / 2): as many leave as must
};

TEST_F(RtUnitStack, PairsLeaveOneACycleAndComeBackOneByOne) {
  for (const Case& c : {Case{5, 2, 2}, Case{5, 3, 1}, Case{5, 4, 1}, Case{6, 2, 2}, Case{6, 3, 2}, Case{3, 2, 1}}) {
    SCOPED_TRACE(std::to_string(c.children) + " children, " + std::to_string(c.stack_entries) + " entries");
    const auto group = fan(c.children, leaves(c.children));
    const Run deep = run(small_header(), group, 0);
    const Run spilled = run(small_header(), group, c.stack_entries);
    // p pairs are sent in the cycle of the result and the p - 1 cycles after it; each comes back after kMemory cycles.
    EXPECT_EQ(spilled.done, deep.done + (c.pairs - 1) + c.pairs * kMemory);
    EXPECT_EQ(spilled.counters.spills, c.pairs);
    EXPECT_EQ(spilled.counters.fills, c.pairs);
    EXPECT_EQ(spilled.counters.max_spilled, 2 * c.pairs);
    std::vector<Move> expected;
    for (unsigned p = 0; p < c.pairs; ++p) expected.push_back({true, p});
    for (unsigned p = c.pairs; p-- > 0;) expected.push_back({false, p});
    EXPECT_EQ(spilled.moves, expected);
    for (unsigned p = 1; p < c.pairs; ++p) EXPECT_EQ(spilled.sent[p], spilled.sent[0] + p);
  }
}

// Without a t an entry takes 8 B, and four of them move at a time.
TEST_F(RtUnitStack, EntriesWithoutTMoveByFours) {
  traces::Header header = small_header();
  header.pop_test = traces::PopTest::off;
  const auto group = fan(6, leaves(6));
  const Run spilled = run(header, group, 4);
  EXPECT_EQ(spilled.moves, (std::vector<Move>{{true, 0}, {false, 0}}));
  EXPECT_EQ(spilled.counters.max_spilled, 4U);
  EXPECT_EQ(spilled.done, run(header, group, 0).done + kMemory);
  EXPECT_THROW(run(header, group, 3), Error) << "a sector would not fit";
}

TEST_F(RtUnitStack, CullsTakeFromTheStackToo) {
  std::vector<Event> events = leaves(1);
  for (unsigned i = 1; i < 5; ++i) events.push_back(cull_event(2 + i, 0));
  const auto group = fan(5, events);
  EXPECT_EQ(run(small_header(), group, 2).done, run(small_header(), group, 0).done + 1 + 2 * kMemory);
}

// Checkpoint entries of the same event wait for the stack: both are handed over in the cycle of the last spill.
TEST_F(RtUnitStack, SpillsComeBeforeCheckpointEntries) {
  traces::RayGroup group = fan(6, {});
  traces::Ray& ray = group.rays[0];
  ray = {};
  add_round(ray,
            {internal_event(0, 0b111110, 0b000001), leaf_event(3, LeafOutcome::miss), leaf_event(4, LeafOutcome::miss),
             leaf_event(5, LeafOutcome::miss), leaf_event(6, LeafOutcome::miss), leaf_event(7, LeafOutcome::miss)});
  const traces::Header header = small_header("tri20", 100);
  EXPECT_EQ(run(header, group, 2).done, run(header, group, 0).done + 1 + 2 * kMemory);
}

// Two lanes that spill in the same cycle: the sectors of the second wait for those of the first.
TEST_F(RtUnitStack, LanesShareThePort) {
  traces::RayGroup group = fan(5, leaves(5));
  group.rays.push_back(group.rays[0]);
  BenchOptions options;
  options.memory_latency = kMemory;
  options.rt.warp_buffer.spill = true;
  options.rt.warp_buffer.stack_entries = 2;
  RtBench bench(small_header(), options);
  bench.run(group);
  ASSERT_EQ(bench.requests[3].size(), 8U);
  for (unsigned i = 1; i < 4; ++i) {
    EXPECT_EQ(bench.requests[3][i].cycle, bench.requests[3][0].cycle + i);
    EXPECT_EQ(bench.requests[3][i].request.tag, i / 2) << "lane 0's two pairs, then lane 1's";
  }
}

}  // namespace
}  // namespace grtx::sim
