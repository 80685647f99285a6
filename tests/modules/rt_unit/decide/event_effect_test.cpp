// SPDX-License-Identifier: Apache-2.0
// What each kind of event does to its lane: a table.
#include "grtx/modules/rt_unit/decide/event_effect.h"

#include <gtest/gtest.h>

#include <vector>

namespace grtx::modules {
namespace {

using traces::Event;
using traces::EventKind;
using traces::LeafOutcome;

struct EffectCase {
  const char* name;
  EventKind kind;
  unsigned detail;
  unsigned entries;  ///< Event::checkpoints
  int stack;         ///< change of the depth
  unsigned checkpoints;
  bool takes_top, any_hit;
};
void PrintTo(const EffectCase& c, std::ostream* out) { *out << c.name; }

constexpr unsigned detail_of(LeafOutcome outcome) { return static_cast<unsigned>(outcome); }

class EventEffectOf : public testing::TestWithParam<EffectCase> {};

TEST_P(EventEffectOf, IsThatOfTheTable) {
  const EffectCase& c = GetParam();
  const Event event{7, static_cast<std::uint8_t>(c.detail), static_cast<std::uint8_t>(c.entries), Event::pack(c.kind)};
  const EventEffect effect(event);
  EXPECT_EQ(effect.takes_top(), c.takes_top);
  EXPECT_EQ(effect.replays(), !c.takes_top);
  EXPECT_EQ(effect.calls_any_hit(), c.any_hit);
  EXPECT_EQ(effect.checkpoints(), c.checkpoints);
  std::uint16_t depth = 5;
  EXPECT_TRUE(effect.move_stack(depth));
  EXPECT_EQ(depth, 5 + c.stack);
  std::uint32_t empty = 0;
  EXPECT_EQ(effect.move_stack(empty), !c.takes_top) << "a node on the stack is needed by all but replays";
}

INSTANTIATE_TEST_SUITE_P(
    Events, EventEffectOf,
    testing::Values(
        EffectCase{"internal_without_hits", EventKind::visit_internal, 0, 0, -1, 0, true, false},
        EffectCase{"internal_pushes_three", EventKind::visit_internal, 0b100110, 0, 2, 0, true, false},
        EffectCase{"internal_mask_of_entries", EventKind::visit_internal, 0b1, 0b110010, 0, 3, true, false},
        EffectCase{"instance_enters_blas", EventKind::visit_instance, 0, 0, 0, 0, true, false},
        EffectCase{"instance_transforms_only", EventKind::visit_instance, 1, 0, 0, 0, true, false},
        EffectCase{"leaf_missed", EventKind::visit_leaf, detail_of(LeafOutcome::miss), 0, -1, 0, true, false},
        EffectCase{"leaf_beyond", EventKind::visit_leaf, detail_of(LeafOutcome::beyond), 1, -1, 1, true, false},
        EffectCase{"leaf_inserted", EventKind::visit_leaf, detail_of(LeafOutcome::inserted), 0, -1, 0, true, true},
        EffectCase{"leaf_ignored", EventKind::visit_leaf, detail_of(LeafOutcome::ignored), 0, -1, 0, true, true},
        EffectCase{"leaf_nearest", EventKind::visit_leaf, detail_of(LeafOutcome::nearest), 0, -1, 0, true, false},
        EffectCase{"cull_dropped", EventKind::cull, 0, 0, -1, 0, true, false},
        EffectCase{"cull_kept", EventKind::cull, 0, 1, -1, 1, true, false},
        EffectCase{"take", EventKind::replay_take, 0, 0, 1, 0, false, false},
        EffectCase{"forward", EventKind::replay_forward, 0, 1, 0, 1, false, false}),
    [](const testing::TestParamInfo<EffectCase>& test) { return std::string(test.param.name); });

TEST(EventEffect, SourceEntriesOfARoundAreItsReplays) {
  const auto of = [](EventKind kind) { return Event{0, 0, 0, Event::pack(kind)}; };
  const std::vector<Event> round = {of(EventKind::replay_forward), of(EventKind::replay_take),
                                    of(EventKind::visit_internal), of(EventKind::cull), of(EventKind::replay_take)};
  EXPECT_EQ(source_entries(round), 3u);
}

TEST(EventEffect, LanesOfABatchBringOutcomeAndShifts) {
  AnyHitBatch batch;
  add_lane(batch, 3, {0, detail_of(LeafOutcome::displaced), 0, Event::pack(EventKind::visit_leaf, 300)});
  EXPECT_EQ(batch.lanes, 0b1000u);
  EXPECT_EQ(batch.outcome[3], LeafOutcome::displaced);
  EXPECT_EQ(batch.shifts[3], 300);
}

}  // namespace
}  // namespace grtx::modules
