// Which nodes of a lane's traversal stack are prefetched, and when: never one that does not lie on it.
#include "grtx/modules/rt_unit/decide/stack_prefetch.h"

#include <gmock/gmock.h>

#include <vector>

namespace grtx::modules {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using traces::Event;
using traces::EventKind;
using traces::LeafOutcome;
using traces::NodeKind;

constexpr std::uint8_t kMiss = static_cast<std::uint8_t>(LeafOutcome::miss);

Event event(EventKind kind, std::uint32_t node, unsigned detail = 0) {
  return {node, static_cast<std::uint8_t>(detail), 0, Event::pack(kind)};
}

/// Node 1 has the children 10 (internal), 11, 12 and 13 (triangles), node 10 the triangles 30 and 31. From the top the
/// stack is, after each event: 10 11 13 12 | 30 31 11 13 12 | 31 11 13 12 | 11 13 12 | 13 12 | 12 | nothing.
class StackPrefetchTest : public testing::Test {
 protected:
  StackPrefetchTest() {
    group.nodes.resize(2);
    group.nodes[0].address = 1;
    group.nodes[0].child_base = 10;
    group.nodes[0].child_count = 4;
    for (const std::size_t i : {1U, 2U, 3U}) group.nodes[0].child_kinds[i] = NodeKind::triangle;
    group.nodes[1].address = 10;
    group.nodes[1].child_base = 30;
    group.nodes[1].child_count = 2;
    group.nodes[1].child_kinds = {NodeKind::triangle, NodeKind::triangle};
    events = {event(EventKind::visit_internal, 0, 0b1111), event(EventKind::visit_internal, 1, 0b11),
              event(EventKind::visit_leaf, 30, kMiss),     event(EventKind::visit_leaf, 31, kMiss),
              event(EventKind::visit_leaf, 11, kMiss),     event(EventKind::cull, 13),
              event(EventKind::visit_leaf, 12, kMiss)};
    header.accel = traces::AccelKind::tri20;
    header.bvh_width = 6;
  }
  /// What each event asks for, in units; on_chip: entries of the stack that are not in memory.
  std::vector<std::vector<std::uint64_t>> asked(const StackPrefetchConfig& config, std::uint32_t on_chip = 100,
                                                bool room = true) {
    const NodeTraffic traffic(header, {});
    StackPrefetch stacks(2, config, traffic);
    stacks.begin(1, group, events);
    std::vector<std::vector<std::uint64_t>> all(events.size());
    for (std::size_t e = 0; e < events.size(); ++e) {
      stacks.moved(1, events.size() - e, on_chip, [&](const StackPrefetch::Node& node) {
        all[e].push_back(node.address / traces::kNodeUnit);
        kinds.push_back(node.kind);
        culled += node.culled ? 1 : 0;
        return room;
      });
    }
    return all;
  }
  traces::Header header;
  traces::RayGroup group;
  std::vector<Event> events;
  std::vector<NodeKind> kinds;
  unsigned culled = 0;
};

TEST_F(StackPrefetchTest, EachPopAsksForThoseBelowTheTopOnce) {
  EXPECT_THAT(asked({2, StackTrigger::pop, 1}),
              ElementsAre(IsEmpty(), IsEmpty(), ElementsAre(11, 13), ElementsAre(12), IsEmpty(), IsEmpty(), IsEmpty()));
  EXPECT_EQ(culled, 1u) << "13 lies on the stack until it is culled";
  EXPECT_THAT(kinds, ElementsAre(NodeKind::triangle, NodeKind::triangle, NodeKind::triangle));
}

TEST_F(StackPrefetchTest, OneEntryBelowTheTopIsAskedForAsItComesUp) {
  EXPECT_THAT(asked({1, StackTrigger::pop, 1}), ElementsAre(IsEmpty(), IsEmpty(), ElementsAre(11), ElementsAre(13),
                                                            ElementsAre(12), IsEmpty(), IsEmpty()));
}

TEST_F(StackPrefetchTest, PopsMayHaveToBeInSuccession) {
  EXPECT_THAT(asked({2, StackTrigger::pop, 2}),
              ElementsAre(IsEmpty(), IsEmpty(), IsEmpty(), ElementsAre(13, 12), IsEmpty(), IsEmpty(), IsEmpty()));
  EXPECT_THAT(asked({2, StackTrigger::pop, 3}),
              ElementsAre(IsEmpty(), IsEmpty(), IsEmpty(), IsEmpty(), ElementsAre(12), IsEmpty(), IsEmpty()));
}

TEST_F(StackPrefetchTest, APushAsksForTheOtherChildren) {
  EXPECT_THAT(asked({3, StackTrigger::push, 1}), ElementsAre(ElementsAre(11, 13, 12), ElementsAre(31), IsEmpty(),
                                                             IsEmpty(), IsEmpty(), IsEmpty(), IsEmpty()));
}

TEST_F(StackPrefetchTest, EntriesInMemoryAreNotSeen) {
  EXPECT_THAT(asked({4, StackTrigger::push, 1}, 2),
              ElementsAre(ElementsAre(11), ElementsAre(31), IsEmpty(), IsEmpty(), IsEmpty(), IsEmpty(), IsEmpty()));
}

TEST_F(StackPrefetchTest, WhatFindsNoRoomIsAskedForAgain) {
  EXPECT_THAT(
      asked({1, StackTrigger::pop, 1}, 100, false),
      ElementsAre(IsEmpty(), IsEmpty(), ElementsAre(11), ElementsAre(13), ElementsAre(12), IsEmpty(), IsEmpty()));
}

TEST_F(StackPrefetchTest, TheTopIsAskedForWhileTheShaderRuns) {
  events[2].detail = static_cast<std::uint8_t>(LeafOutcome::inserted);
  EXPECT_THAT(asked({1, StackTrigger::pop, 1}), ElementsAre(IsEmpty(), IsEmpty(), ElementsAre(31), ElementsAre(13),
                                                            ElementsAre(12), IsEmpty(), IsEmpty()));
}

TEST_F(StackPrefetchTest, ARootBelowAnInstanceLeafTakesItsPlace) {
  header.accel = traces::AccelKind::tlas_tri20;
  header.two_level = true;
  header.blas_base = 9000 * traces::kNodeUnit;
  group.nodes[0].child_kinds = {NodeKind::instance, NodeKind::instance};
  group.nodes[0].child_count = 2;
  events = {event(EventKind::visit_internal, 0, 0b11), event(EventKind::visit_instance, 10),
            event(EventKind::visit_leaf, 9001, kMiss), event(EventKind::cull, 12)};
  EXPECT_THAT(asked({2, StackTrigger::push, 1}), ElementsAre(ElementsAre(12), IsEmpty(), IsEmpty(), IsEmpty()));
  EXPECT_THAT(kinds, ElementsAre(NodeKind::instance));
}

TEST_F(StackPrefetchTest, WhatIsReplayedLiesAloneOnTheStack) {
  events.insert(events.begin(), event(EventKind::replay_take, 1));
  events.push_back(event(EventKind::replay_take, 30));
  events.push_back(event(EventKind::visit_leaf, 30, kMiss));
  EXPECT_THAT(asked({8, StackTrigger::pop, 1}),
              ElementsAre(IsEmpty(), IsEmpty(), IsEmpty(), ElementsAre(11, 13, 12), IsEmpty(), IsEmpty(), IsEmpty(),
                          IsEmpty(), IsEmpty(), IsEmpty()));
}

}  // namespace
}  // namespace grtx::modules
