// SPDX-License-Identifier: Apache-2.0
// The order of a round's events when several nodes of a ray are under way: docs/model/tracer.md, "Nodes under way".
#include "grtx/report/ray/handled_order.h"

#include <gmock/gmock.h>

namespace grtx::report {
namespace {

using testing::ElementsAre;
using traces::Event;
using traces::EventKind;

Event event(EventKind kind, std::uint8_t pushed = 0) { return {0, pushed, 0, Event::pack(kind)}; }

// The root pushes A, B, C, A the topmost; A pushes A1, A2. Depth first: 0 root, 1 A, 2 A1, 3 A2, 4 B, 5 C.
std::vector<Event> events_with(EventKind a2) {
  const Event leaf = event(EventKind::visit_leaf);
  return {event(EventKind::visit_internal, 0b111), event(EventKind::visit_internal, 0b11), leaf, event(a2), leaf, leaf};
}
std::vector<std::size_t> order_of(EventKind a2, unsigned ahead) { return handled_order(events_with(a2), ahead).events; }

TEST(HandledOrder, WithOneNodeUnderWayIsDepthFirst) {
  EXPECT_THAT(order_of(EventKind::visit_leaf, 1), ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST(HandledOrder, TheNodeStartedFirstIsDoneFirst) {
  // After the root A and B start. A done, its children come where it was: A1 starts. B done: A2. A1 done: C.
  EXPECT_THAT(order_of(EventKind::visit_leaf, 2), ElementsAre(0, 1, 4, 2, 3, 5));
  // With room for three C starts with A and B, before the children of A.
  EXPECT_THAT(order_of(EventKind::visit_leaf, 3), ElementsAre(0, 1, 4, 5, 2, 3));
}

TEST(HandledOrder, ACullComesWhenItsNodeWouldStart) {
  EXPECT_THAT(order_of(EventKind::cull, 2), ElementsAre(0, 1, 4, 3, 2, 5));  // A2 when B is done, C starts in its place
}

TEST(HandledOrder, ChildrenAreThoseOfThePush) {
  const auto children = children_of(events_with(EventKind::visit_leaf));
  EXPECT_THAT(children[0], ElementsAre(1, 4, 5));
  EXPECT_THAT(children[1], ElementsAre(2, 3));
  EXPECT_THAT(children[2], ElementsAre());
}

TEST(HandledOrder, ChildrenOfAReplayAreWhatWasTaken) {
  // A node inside an instance is taken: the ray is transformed, the node pushes a leaf. Another entry is forwarded.
  Event transform = event(EventKind::visit_instance, 1);
  const std::vector<Event> events = {event(EventKind::replay_take), transform, event(EventKind::visit_internal, 0b1),
                                     event(EventKind::visit_leaf), event(EventKind::replay_forward)};
  EXPECT_THAT(children_of(events),
              ElementsAre(ElementsAre(2), ElementsAre(), ElementsAre(3), ElementsAre(), ElementsAre()));
}

TEST(HandledOrder, NodesAreStartedWhenThereIsRoom) {
  EXPECT_THAT(handled_order(events_with(EventKind::visit_leaf), 2).started,
              ElementsAre(ElementsAre(0), ElementsAre(1, 4), ElementsAre(2), ElementsAre(3), ElementsAre(5),
                          ElementsAre(), ElementsAre()));
  // B is done, A2 is culled in its turn, and C starts.
  EXPECT_THAT(handled_order(events_with(EventKind::cull), 2).started,
              ElementsAre(ElementsAre(0), ElementsAre(1, 4), ElementsAre(2), ElementsAre(), ElementsAre(5),
                          ElementsAre(), ElementsAre()));
}

TEST(HandledOrder, ARoundWithoutEventsHasNone) { EXPECT_THAT(handled_order({}, 4).events, ElementsAre()); }

}  // namespace
}  // namespace grtx::report
