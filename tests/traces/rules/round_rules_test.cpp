// SPDX-License-Identifier: Apache-2.0
// The rules of a round that tracer, trace-check and the page of a ray share: docs/model/tracer.md, "Rounds".
#include "grtx/traces/rules/round_rules.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace grtx::traces {
namespace {

using ::testing::HasSubstr;

constexpr unsigned kK = 4;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

RoundRules rules_of(Tracing tracing, bool kth = false, AnyHit any_hit = AnyHit::immediate) {
  return {tracing, any_hit, kK, false, kth};
}

TEST(RoundRules, AHitIsInsertedDisplacesAnotherOrIsRejected) {
  for (const Tracing tracing : {Tracing::multi, Tracing::single, Tracing::list}) {
    const RoundRules rules = rules_of(tracing);
    EXPECT_EQ(rules.outcome(false, false), LeafOutcome::inserted);
    EXPECT_EQ(rules.outcome(true, true), LeafOutcome::displaced);
    EXPECT_EQ(rules.outcome(true, false), LeafOutcome::rejected);
  }
  const RoundRules closest = rules_of(Tracing::closest);
  EXPECT_EQ(closest.outcome(false, false), LeafOutcome::nearest);
  EXPECT_EQ(closest.outcome(true, true), LeafOutcome::nearest);
  EXPECT_EQ(closest.outcome(true, false), LeafOutcome::beyond);
}

TEST(RoundRules, OnlyARejectedHitMovesTmax) {
  const RoundRules rules = rules_of(Tracing::multi);
  EXPECT_EQ(rules.t_max(LeafOutcome::inserted, kInfinity, 2.0f, 3.0f), kInfinity);
  EXPECT_EQ(rules.t_max(LeafOutcome::displaced, kInfinity, 2.0f, 3.0f), kInfinity);
  EXPECT_EQ(rules.t_max(LeafOutcome::rejected, kInfinity, 5.0f, 3.0f), 5.0f);
  EXPECT_EQ(rules.t_max(LeafOutcome::rejected, 4.0f, 5.0f, 3.0f), 4.0f);  // of an instance that is finished
}

TEST(RoundRules, TmaxFollowsTheKthHitOfAFullBuffer) {
  const RoundRules rules = rules_of(Tracing::multi, true);
  EXPECT_EQ(rules.t_max(LeafOutcome::inserted, 9.0f, 2.0f, kInfinity), 9.0f);
  EXPECT_EQ(rules.t_max(LeafOutcome::inserted, 9.0f, 2.0f, 3.0f), 3.0f);
  EXPECT_EQ(rules.t_max(LeafOutcome::displaced, 9.0f, 2.0f, 3.0f), 3.0f);
  EXPECT_EQ(rules.t_max(LeafOutcome::rejected, 9.0f, 5.0f, 3.0f), 3.0f);
}

TEST(RoundRules, TheNearestHitIsTmaxAndDelayedShadersMoveNone) {
  EXPECT_EQ(rules_of(Tracing::closest).t_max(LeafOutcome::nearest, 9.0f, 2.0f, 2.0f), 2.0f);
  const RoundRules delayed = rules_of(Tracing::multi, true, AnyHit::delayed);
  EXPECT_EQ(delayed.t_max(LeafOutcome::rejected, 9.0f, 5.0f, 3.0f), 9.0f);
}

struct Broken {
  Tracing tracing;
  LeafOutcome outcome;
  unsigned shifts;
  std::uint64_t held;
  const char* rule;  ///< "": none
};

TEST(RoundRules, ARecordedOutcomeIsOneThatTheRulesGive) {
  constexpr Broken kCases[] = {
      {Tracing::multi, LeafOutcome::inserted, 3, 3, ""},
      {Tracing::multi, LeafOutcome::inserted, 4, 3, "cannot shift more entries"},
      {Tracing::multi, LeafOutcome::inserted, 0, 4, "an insertion needs room"},
      {Tracing::multi, LeafOutcome::displaced, 3, 4, ""},
      {Tracing::multi, LeafOutcome::displaced, 4, 4, "cannot shift more entries"},
      {Tracing::multi, LeafOutcome::displaced, 0, 3, "only a full k-buffer displaces or rejects"},
      {Tracing::multi, LeafOutcome::rejected, 0, 4, ""},
      {Tracing::multi, LeafOutcome::rejected, 0, 3, "only a full k-buffer displaces or rejects"},
      {Tracing::multi, LeafOutcome::rejected, 1, 4, "only an insertion shifts"},
      {Tracing::multi, LeafOutcome::nearest, 0, 0, "only closest-hit tracing commits"},
      {Tracing::single, LeafOutcome::inserted, 1, 2, "appends without moving"},
      {Tracing::single, LeafOutcome::inserted, 2, 3, ""},  // makes the heap
      {Tracing::single, LeafOutcome::displaced, 2, 4, ""},
      {Tracing::single, LeafOutcome::displaced, 3, 4, "at most log2(k)"},
      {Tracing::closest, LeafOutcome::nearest, 0, 1, ""},
      {Tracing::closest, LeafOutcome::ignored, 0, 1, "calls no any-hit shader"},
  };
  for (const Broken& c : kCases) {
    const char* const rule = rules_of(c.tracing).broken_by(c.outcome, c.shifts, c.held, true);
    const std::string said = rule == nullptr ? "" : rule;
    EXPECT_EQ(said.empty(), c.rule[0] == '\0') << said;
    EXPECT_THAT(said, HasSubstr(c.rule)) << static_cast<int>(c.tracing) << " " << static_cast<int>(c.outcome) << " of "
                                         << c.held;
  }
}

TEST(RoundRules, EventsInAnotherOrderMayFindTheBufferPartlyFilled) {
  const RoundRules rules = rules_of(Tracing::multi);
  EXPECT_EQ(rules.broken_by(LeafOutcome::displaced, 2, 1, false), nullptr);
  EXPECT_EQ(rules.broken_by(LeafOutcome::inserted, 3, 1, false), nullptr);
  EXPECT_THAT(rules.broken_by(LeafOutcome::inserted, 0, kK, false), HasSubstr("needs room"));
  EXPECT_THAT(rules.broken_by(LeafOutcome::displaced, kK, 1, false), HasSubstr("cannot shift"));
}

TEST(RoundRules, ARayGoesOnBehindAFullBuffer) {
  Round round;
  round.k_count = kK;
  const RoundRules rules = rules_of(Tracing::multi);
  EXPECT_TRUE(rules.goes_on(round));
  round.terminated = true;
  EXPECT_FALSE(rules.goes_on(round));
  round.terminated = false;
  round.k_count = kK - 1;
  EXPECT_FALSE(rules.goes_on(round));
  const RoundRules checkpoints(Tracing::multi, AnyHit::immediate, kK, true, false);
  EXPECT_FALSE(rules.replays_after(round));
  EXPECT_TRUE(checkpoints.replays_after(round));
  round.overflow = true;
  EXPECT_FALSE(checkpoints.replays_after(round));
}

}  // namespace
}  // namespace grtx::traces
