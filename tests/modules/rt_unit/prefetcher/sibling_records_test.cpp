// SPDX-License-Identifier: Apache-2.0
// Which siblings a leaf brings along.
#include "grtx/modules/rt_unit/prefetcher/decide/sibling_records.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace grtx::modules {
namespace {

using traces::NodeKind;

/// Node 0: children at 10 (internal), 11, 12, 13 (triangles). Node 1: the same four addresses, as of another visit.
/// Node 2: two internal children at 20 and 21.
class SiblingRecordsTest : public testing::Test {
 protected:
  SiblingRecordsTest() {
    group.nodes.resize(3);
    for (const std::size_t n : {0U, 1U}) {
      group.nodes[n].child_base = 10;
      group.nodes[n].child_count = 4;
      for (const std::size_t i : {1U, 2U, 3U}) group.nodes[n].child_kinds[i] = NodeKind::triangle;
    }
    group.nodes[2].child_base = 20;
    group.nodes[2].child_count = 2;
  }
  static NodeTraffic traffic() {
    traces::Header header;
    header.accel = traces::AccelKind::tri20;
    header.bvh_width = 6;
    return {header, {}};
  }
  traces::RayGroup group;
  SiblingRecords records{2, 2, true, traffic()};
};

TEST_F(SiblingRecordsTest, TheFirstOfTheHitChildrenBringsTheOthersOnce) {
  records.note(0, group, 0, 0b1110, 0);
  EXPECT_EQ(records.take(0, group, 12).mask, 0b1010u);
  EXPECT_EQ(records.take(0, group, 11).mask, 0u);
  EXPECT_EQ(records.take(1, group, 11).mask, 0u) << "another lane";
}

TEST_F(SiblingRecordsTest, OneHitOrNoLeafIsNotRemembered) {
  records.note(0, group, 0, 0b0010, 0);
  records.note(0, group, 2, 0b0011, 0);
  EXPECT_EQ(records.take(0, group, 11).mask, 0u);
  EXPECT_EQ(records.take(0, group, 20).mask, 0u);
}

TEST_F(SiblingRecordsTest, AChildThatWasNotHitIsOfAnOlderVisit) {
  records.note(0, group, 0, 0b1010, 0);
  records.note(0, group, 1, 0b0101, 0);
  const Siblings older = records.take(0, group, 13);
  EXPECT_EQ(older.definition, 0u);
  EXPECT_EQ(older.mask, 0b0010u);
  EXPECT_EQ(records.take(0, group, 12).definition, 1u);
}

TEST_F(SiblingRecordsTest, ANewVisitReplacesTheOldest) {
  records.note(0, group, 0, 0b1010, 0);
  records.note(0, group, 1, 0b0101, 0);
  records.note(0, group, 1, 0b0110, 0);
  EXPECT_EQ(records.take(0, group, 13).mask, 0u);
  EXPECT_EQ(records.take(0, group, 12).mask, 0b0010u) << "the newest of two visits that hit it";
}

TEST_F(SiblingRecordsTest, ARoundBeginsWithNothing) {
  records.note(0, group, 0, 0b1110, 0);
  records.begin(0, 0, false);
  EXPECT_EQ(records.take(0, group, 12).mask, 0u);
}

TEST_F(SiblingRecordsTest, AReplayedLeafBringsThoseThatWereCheckpointedWithItOncePerRound) {
  records.begin(0, 5, false);
  records.note(0, group, 0, 0b0001, 0b1110);
  records.begin(1, 5, true);  // the next round, in another lane of the warp buffer
  EXPECT_EQ(records.take(1, group, 12).mask, 0u) << "nobody has replayed it";
  records.note_replayed(1, 12);
  const Siblings siblings = records.take(1, group, 12);
  EXPECT_EQ(siblings.definition, 0u);
  EXPECT_EQ(siblings.mask, 0b1010u);
  EXPECT_TRUE(siblings.replayed);
  records.note_replayed(1, 11);
  EXPECT_EQ(records.take(1, group, 11).mask, 0u) << "brought along before";
  records.begin(0, 5, true);  // a round later the entries still say it
  records.note_replayed(0, 11);
  EXPECT_EQ(records.take(0, group, 11).mask, 0b1100u);
}

TEST_F(SiblingRecordsTest, AChildThatWasCheckpointedAloneHasNoSiblings) {
  records.begin(0, 0, false);
  records.note(0, group, 0, 0b1100, 0b0010);
  records.note(0, group, 2, 0, 0b0011);  // two, but no leaf
  records.begin(0, 0, true);
  for (const std::uint32_t address : {11u, 12u, 20u}) {
    records.note_replayed(0, address);
    EXPECT_EQ(records.take(0, group, address).mask, 0u) << address;
  }
}

TEST_F(SiblingRecordsTest, AVisitThatHitOneChildPushesNoOtherOut) {
  records.note(0, group, 0, 0b1010, 0);
  records.note(0, group, 1, 0b1100, 0);  // two: as many as a lane remembers
  records.note(0, group, 0, 0b0100, 0);
  EXPECT_EQ(records.take(0, group, 11).mask, 0b1000u);
  EXPECT_EQ(records.take(0, group, 12).mask, 0b1000u);
}

TEST_F(SiblingRecordsTest, AChildThatWasCheckpointedAloneHidesNoOlderVisit) {
  records.begin(0, 0, false);
  records.note(0, group, 0, 0, 0b1110);
  records.note(0, group, 1, 0, 0b0010);
  records.begin(0, 0, true);
  records.note_replayed(0, 11);
  EXPECT_EQ(records.take(0, group, 11).mask, 0b1100u);
}

TEST_F(SiblingRecordsTest, TheHighestChildBringsItsSiblingsToo) {
  records.begin(0, 0, false);
  records.note(0, group, 0, 0, 0b1010);
  records.note(0, group, 1, 0, 0b0110);  // newer, but not of the child that is replayed
  records.begin(0, 0, true);
  records.note_replayed(0, 13);
  EXPECT_EQ(records.take(0, group, 13).mask, 0b0010u);
}

TEST_F(SiblingRecordsTest, ARoundFromTheRootHasNoEntriesThatSaySiblings) {
  records.begin(0, 0, false);
  records.note(0, group, 0, 0, 0b1110);
  records.begin(0, 0, false);
  records.note_replayed(0, 12);
  EXPECT_EQ(records.take(0, group, 12).mask, 0u);
}

TEST_F(SiblingRecordsTest, WithoutReplayedEntriesSayNothing) {
  SiblingRecords without{2, 2, false, traffic()};
  without.begin(0, 0, false);
  without.note(0, group, 0, 0, 0b1110);
  without.begin(0, 0, true);
  without.note_replayed(0, 12);
  EXPECT_EQ(without.take(0, group, 12).mask, 0u);
}

TEST_F(SiblingRecordsTest, ChildrenLieOneBehindTheOther) {
  std::vector<std::pair<NodeKind, std::uint32_t>> children;
  records.for_each_child(group.nodes[0], 0b1001,
                         [&](NodeKind kind, std::uint32_t at) { children.emplace_back(kind, at); });
  EXPECT_EQ(children,
            (std::vector<std::pair<NodeKind, std::uint32_t>>{{NodeKind::internal, 10}, {NodeKind::triangle, 13}}));
}

TEST(SiblingRequests, LanesOfAWarpAskForASiblingOnce) {
  SiblingRequests requests;
  EXPECT_EQ(requests.fresh({4, 0b0110}), 0b0110u);
  EXPECT_EQ(requests.fresh({4, 0b1100}), 0b1000u);
  EXPECT_EQ(requests.fresh({5, 0b1100}), 0b1100u);
  requests.begin();
  EXPECT_EQ(requests.fresh({4, 0b0110}), 0b0110u);
}

}  // namespace
}  // namespace grtx::modules
