// SPDX-License-Identifier: Apache-2.0
// Whether a sibling is queued for prefetch, merged with one that is on its way, or dropped.
#include "grtx/modules/rt_unit/prefetcher/decide/prefetch_decisions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace grtx::modules {
namespace {

using traces::NodeKind;

/// A queue of so many places.
struct Queue {
  explicit Queue(std::size_t room) : places(room) {}
  bool waits(std::uint64_t address) const { return std::find(queued.begin(), queued.end(), address) != queued.end(); }
  bool full() const { return queued.size() == places; }
  void push(NodeKind, std::uint64_t address) { queued.push_back(address); }
  std::size_t places;
  std::vector<std::uint64_t> queued;
};

/// Node 0 has four triangle leaves, at units 10 to 13.
class PrefetchDecisionsTest : public ::testing::Test {
 protected:
  PrefetchDecisionsTest() {
    group.nodes.resize(1);
    group.nodes[0].child_base = 10;
    group.nodes[0].child_count = 4;
    for (std::size_t i = 0; i < 4; ++i) group.nodes[0].child_kinds[i] = NodeKind::triangle;
    for (unsigned i = 0; i < 4; ++i) address[i] = traffic.address(10 + i);
  }
  static traces::Header header() {
    traces::Header header;
    header.accel = traces::AccelKind::tri20;
    header.bvh_width = 6;
    return header;
  }
  /// The lane has hit the children in `hit`, and now visits the first of them.
  void visit(std::size_t lane, unsigned hit, Queue& queue) {
    decisions.note_internal(lane, group, 0, hit, 0);
    const Siblings siblings = decisions.take(lane, group, 10 + static_cast<unsigned>(std::countr_zero(hit)));
    if (siblings.mask != 0) decisions.ask_for(siblings, group, queue);
  }

  traces::RayGroup group;
  NodeTraffic traffic{header(), {}};
  std::uint64_t address[4];
  PrefetchDecisions decisions{2, PrefetcherConfig(), PrefetchTriggers(), traffic};
};

TEST_F(PrefetchDecisionsTest, TheOtherHitChildrenOfALeafsParentAreQueued) {
  Queue queue(8);
  decisions.begin_warp();
  visit(0, 0b1101, queue);
  EXPECT_EQ(queue.queued, (std::vector<std::uint64_t>{address[2], address[3]})) << "in the order of their slots";
  EXPECT_EQ(decisions.counters().triggers, 1u);
  EXPECT_EQ(decisions.counters().nodes, 2u);
}

TEST_F(PrefetchDecisionsTest, LanesOfAWarpAskForASiblingOnce) {
  Queue queue(8);
  decisions.begin_warp();
  visit(0, 0b0111, queue);
  queue.queued.clear();     // gone out at once
  visit(1, 0b1101, queue);  // 2 and 3, of which the first lane asked for 2
  EXPECT_EQ(queue.queued, (std::vector<std::uint64_t>{address[3]}));
  EXPECT_EQ(decisions.counters().merged, 1u);
}

TEST_F(PrefetchDecisionsTest, ASiblingThatWaitsInTheQueueIsMerged) {
  Queue queue(8);
  decisions.begin_warp();
  visit(0, 0b0011, queue);
  decisions.begin_warp();  // selected once more, in a later cycle
  visit(1, 0b0011, queue);
  EXPECT_EQ(queue.queued, (std::vector<std::uint64_t>{address[1]}));
  EXPECT_EQ(decisions.counters().nodes, 1u);
  EXPECT_EQ(decisions.counters().merged, 1u);
}

TEST_F(PrefetchDecisionsTest, ASiblingIsDroppedIfTheQueueIsFull) {
  Queue queue(1);
  decisions.begin_warp();
  visit(0, 0b1111, queue);
  EXPECT_EQ(queue.queued, (std::vector<std::uint64_t>{address[1]}));
  EXPECT_EQ(decisions.counters().nodes, 1u);
  EXPECT_EQ(decisions.counters().dropped, 2u);
}

TEST_F(PrefetchDecisionsTest, NothingIsRememberedWithoutTheTrigger) {
  PrefetchTriggers off;
  off.siblings = false;
  PrefetchDecisions none(2, PrefetcherConfig(), off, traffic);
  none.note_internal(0, group, 0, 0b1111, 0);
  EXPECT_EQ(none.take(0, group, 10).mask, 0u);
}

}  // namespace
}  // namespace grtx::modules
