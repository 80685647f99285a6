// SPDX-License-Identifier: Apache-2.0
// The common stack of a warp: what starts next, where children come, what moves to memory; and a lane's events as a
// tree. docs/model/warp_walk.md.
#include "grtx/modules/rt_unit/warp_walk/decide/warp_stack.h"

#include <gmock/gmock.h>

namespace grtx::modules {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using traces::Event;
using traces::EventKind;
using traces::NodeKind;

WarpStackEntry entry(std::uint32_t address, LaneMask lanes = 1, NodeKind kind = NodeKind::internal) {
  return {address, kind, lanes, {}};
}

/// Addresses of all that can be started one after the other, without anything finishing.
std::vector<std::uint32_t> starts(WarpStack& stack, unsigned room = 128) {
  std::vector<std::uint32_t> addresses;
  for (std::size_t place; (place = stack.next(room, NodeKind::triangle)) != WarpStack::kNone;) {
    addresses.push_back(stack.at(place).address);
    stack.start(place);
  }
  return addresses;
}

void finish(WarpStack& stack, unsigned slot, const std::vector<WarpStackEntry>& children) {
  if (children.empty()) return stack.finish(slot);
  stack.node(slot).children = children;
  while (!stack.write_child(slot)) {
  }
}

WarpStack with_children(WarpStackConfig config, const std::vector<WarpStackEntry>& children) {
  WarpStack stack(config, 2);
  stack.begin(entry(1));
  finish(stack, stack.start(stack.next(128, NodeKind::triangle)), children);
  return stack;
}

TEST(WarpStack, StartsTheTopmostEntriesAsLongAsThereAreSlots) {
  WarpStack stack = with_children({64, 2}, {entry(11), entry(12), entry(13)});
  EXPECT_THAT(starts(stack), ElementsAre(11, 12));
  EXPECT_FALSE(stack.has_slot());
  EXPECT_EQ(stack.waiting(), 1u);
}

TEST(WarpStack, ChildrenComeWhereTheirParentWas) {
  WarpStack stack = with_children({64, 2}, {entry(11), entry(12), entry(13)});
  EXPECT_THAT(starts(stack), ElementsAre(11, 12));
  finish(stack, 1, {entry(21), entry(22)});  // 12 was in slot 1
  EXPECT_THAT(starts(stack), ElementsAre(21));
  stack.finish(0);  // 11, on top
  EXPECT_THAT(starts(stack), ElementsAre(22));
  stack.finish(0);
  EXPECT_THAT(starts(stack), ElementsAre(13));
}

TEST(WarpStack, ALeafWaitsForRoomForItsLanesHitsAndOthersPassIt) {
  WarpStack stack = with_children({64, 3}, {entry(11, 0b111, NodeKind::triangle), entry(12, 0b10, NodeKind::triangle),
                                            entry(13, 0b111), entry(14, 0b01)});
  EXPECT_THAT(starts(stack, 2), ElementsAre(12, 13, 14));
}

TEST(WarpStack, LooksNoDeeperThanItsWindow) {
  const std::vector<WarpStackEntry> children = {entry(11, 1, NodeKind::triangle), entry(12, 1, NodeKind::triangle),
                                                entry(13)};
  for (const unsigned window : {1U, 2U}) {
    WarpStack stack = with_children({64, 4, window}, children);
    EXPECT_THAT(starts(stack, 0), IsEmpty()) << window;
  }
  for (const unsigned window : {3U, 0U}) {
    WarpStack stack = with_children({64, 4, window}, children);
    EXPECT_THAT(starts(stack, 0), ElementsAre(13)) << window;
  }
}

TEST(WarpStack, EntriesUnderWayTakePlacesOfTheWindow) {
  WarpStack stack = with_children({64, 8, 2}, {entry(11), entry(12), entry(13)});
  EXPECT_THAT(starts(stack), ElementsAre(11, 12));
  EXPECT_TRUE(stack.has_slot());
  stack.finish(0);
  EXPECT_THAT(starts(stack), ElementsAre(13));
}

// All children of a node, and of other nodes done in the same cycle, came at once.
TEST(WarpStack, ChildrenComeOneByOneBelowEachOther) {
  WarpStack stack = with_children({64, 4}, {entry(11), entry(12)});
  EXPECT_THAT(starts(stack), ElementsAre(11, 12));
  stack.node(0).children = {entry(21), entry(22)};
  EXPECT_FALSE(stack.write_child(0));
  EXPECT_THAT(starts(stack), ElementsAre(21));
  EXPECT_EQ(stack.under_way(), 3u);  // 11 keeps its slot
  EXPECT_TRUE(stack.write_child(0));
  EXPECT_EQ(stack.under_way(), 2u);
  EXPECT_THAT(starts(stack), ElementsAre(22));
}

TEST(WarpStack, SpillsTheLowestThatWaitAndFillsThemWhenNoneIsLeft) {
  std::vector<WarpStackEntry> eight;
  for (std::uint32_t i = 0; i < 8; ++i) eight.push_back(entry(10 + i));
  WarpStack stack = with_children({10, 1}, eight);
  const unsigned slot = stack.start(stack.next(128, NodeKind::triangle));  // 10: seven wait
  EXPECT_TRUE(stack.has_room(3));
  ASSERT_FALSE(stack.has_room(4));
  const StackSpill::Move move = stack.settle(4, false);
  EXPECT_EQ(move.spills, 1u);
  EXPECT_EQ(move.first, 0u);
  EXPECT_EQ(stack.waiting(), 5u);
  EXPECT_EQ(stack.in_memory(), 2u);
  stack.finish(slot);
  for (std::uint32_t address = 11; address < 16; ++address) {
    EXPECT_THAT(starts(stack), ElementsAre(address));
    stack.finish(0);
  }
  EXPECT_EQ(stack.waiting(), 0u);
  EXPECT_TRUE(stack.settle(0, true).fill);
  stack.filled();
  EXPECT_THAT(starts(stack), ElementsAre(16));
  stack.finish(0);
  EXPECT_THAT(starts(stack), ElementsAre(17));
  stack.finish(0);
  EXPECT_TRUE(stack.empty());
}

/// A node at 1 with leaves at 10 and 11 and a node at 12, which has leaves at 20 and 21.
class LaneTreeTest : public ::testing::Test {
 protected:
  LaneTreeTest() {
    header_.accel = traces::AccelKind::tri20;
    traces::NodeDefinition root{.address = 1, .child_base = 10, .child_count = 3};
    root.child_kinds = {NodeKind::triangle, NodeKind::triangle, NodeKind::internal};
    traces::NodeDefinition inner{.address = 12, .child_base = 20, .child_count = 2};
    inner.child_kinds = {NodeKind::triangle, NodeKind::triangle};
    group_.nodes = {root, inner};
  }
  static Event node(std::uint32_t index, unsigned pushed) {
    return {index, static_cast<std::uint8_t>(pushed), 0, Event::pack(EventKind::visit_internal)};
  }
  static Event leaf(std::uint32_t address) { return {address, 0, 0, Event::pack(EventKind::visit_leaf)}; }
  static Event cull(std::uint32_t address) { return {address, 0, 0, Event::pack(EventKind::cull)}; }
  const char* build(LaneTree& tree, const std::vector<Event>& events) const {
    return tree.build(events, group_, NodeTraffic(header_, {}));
  }
  traces::Header header_;
  traces::RayGroup group_;
};

TEST_F(LaneTreeTest, ChildrenComeInTheOrderOfTheLane) {
  const std::vector<Event> events = {node(0, 0b111), leaf(11), node(1, 0b11), leaf(21), cull(20), leaf(10)};
  LaneTree tree;
  ASSERT_EQ(build(tree, events), nullptr);
  const auto children = [&](std::uint32_t parent) {
    std::vector<std::uint32_t> all;
    tree.for_each_child(parent, [&](std::uint32_t child) { all.push_back(tree.address(child)); });
    return all;
  };
  EXPECT_THAT(children(0), ElementsAre(11, 12, 10));
  EXPECT_THAT(children(2), ElementsAre(21, 20));
  EXPECT_THAT(children(1), IsEmpty());
  EXPECT_EQ(tree.kind(4), NodeKind::triangle);
}

TEST_F(LaneTreeTest, AWarpTakesTheOrderOfItsLowestLaneAndThenWhatOthersPush) {
  std::vector<LaneTree> trees(2);
  const std::vector<Event> first = {node(0, 0b101), node(1, 0), leaf(10)};
  const std::vector<Event> second = {node(0, 0b111), leaf(11), leaf(10), cull(12)};
  ASSERT_EQ(build(trees[0], first), nullptr);
  ASSERT_EQ(build(trees[1], second), nullptr);
  std::vector<WarpStackEntry> children;
  const auto tree = [&](unsigned lane) -> const LaneTree& { return trees[lane]; };
  children_of(entry(1, 0b11), false, tree, children);
  ASSERT_EQ(children.size(), 3u);
  EXPECT_EQ(children[0].address, 12u);
  EXPECT_EQ(children[0].kind, NodeKind::internal);
  EXPECT_EQ(children[0].lanes, 0b11u);
  EXPECT_EQ(children[0].event[1], 3u);
  EXPECT_EQ(children[1].address, 10u);
  EXPECT_EQ(children[1].lanes, 0b11u);
  EXPECT_EQ(children[2].address, 11u);
  EXPECT_EQ(children[2].lanes, 0b10u);
  children_of(entry(1, 0b11), true, tree, children);
  EXPECT_EQ(children[0].address, 10u);
  EXPECT_EQ(children[1].address, 11u);
  EXPECT_EQ(children[2].address, 12u);
}

TEST_F(LaneTreeTest, SaysWhichRuleEventsBreak) {
  LaneTree tree;
  EXPECT_STREQ(build(tree, {node(0, 1)}), kRuleNothingLeft);
  EXPECT_STREQ(build(tree, {node(0, 1), leaf(11)}), kRuleChildPushed);
  EXPECT_STREQ(build(tree, {node(0, 1), leaf(99)}), kRuleChildPushed);
  EXPECT_STREQ(build(tree, {node(0, 0), leaf(10)}), "takes a node from an empty stack");
  EXPECT_STREQ(build(tree, {node(7, 0)}), "visits an internal node that the group does not define");
  EXPECT_STREQ(build(tree, {{1, 0, 0, Event::pack(EventKind::replay_take)}}), kRuleWalkedKinds);
}

}  // namespace
}  // namespace grtx::modules
