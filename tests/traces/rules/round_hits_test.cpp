// SPDX-License-Identifier: Apache-2.0
// Lists of hits: whoever reads outcomes and shifts in a trace has the k-buffer and the evictions of the tracer that
// wrote them.
#include "grtx/traces/rules/round_hits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "grtx/traces/rules/checkpoint_lists.h"

namespace grtx::traces {
namespace {

struct TestHit {
  float t = 0.0f;
  int id = 0;
  std::uint32_t opacity = 0;
  friend bool operator<(const TestHit& a, const TestHit& b) { return a.t < b.t || (a.t == b.t && a.id < b.id); }
  friend bool operator==(const TestHit&, const TestHit&) = default;
};
using Hits = RoundHits<TestHit>;

struct Mode {
  Tracing tracing;
  unsigned k;
  bool checkpoint;
};

TEST(RoundHits, OfAReaderAreThoseOfTheTracer) {
  std::mt19937 random(3);
  for (const Mode mode :
       {Mode{Tracing::multi, 5, true}, Mode{Tracing::multi, 1, false}, Mode{Tracing::closest, 1, false}}) {
    const RoundRules rules(mode.tracing, AnyHit::immediate, mode.k, mode.checkpoint, false);
    Hits tracer(rules), reader(rules);
    std::size_t outcomes[8] = {};
    for (int round = 0; round < 50; ++round) {
      float t_max = std::numeric_limits<float>::infinity(), end = t_max;
      reader.begin_round(tracer.begin_round(1.0f, end));
      for (int i = 0; i < 20; ++i) {
        const TestHit hit{static_cast<float>(random() % 40), i};
        if (hit.t > t_max) continue;
        const std::uint64_t held = reader.k_buffer().size();
        const Hits::Taken taken = tracer.take(hit, t_max, end);
        ++outcomes[static_cast<unsigned>(taken.outcome)];
        ASSERT_EQ(rules.broken_by(taken.outcome, taken.shifts, held, true), nullptr);
        const Hits::Places places = reader.take(hit, taken, held - 1);
        ASSERT_EQ(reader.k_buffer().entries(), tracer.k_buffer().entries());
        ASSERT_EQ(reader.evictions(), tracer.evictions());
        EXPECT_EQ(places.in != Hits::kNowhere, enters(taken.outcome));
        EXPECT_EQ(reader.k_buffer().size(), RoundRules::held_after(taken.outcome, held));
      }
      EXPECT_TRUE(std::is_sorted(tracer.k_buffer().entries().begin(), tracer.k_buffer().entries().end()));
      EXPECT_EQ(tracer.evictions().empty(), reader.evictions().empty());
      EXPECT_TRUE(mode.checkpoint || tracer.evictions().empty());
    }
    const bool closest = mode.tracing == Tracing::closest;
    EXPECT_GT(outcomes[static_cast<unsigned>(closest ? LeafOutcome::nearest : LeafOutcome::displaced)], 20u);
    EXPECT_GT(outcomes[static_cast<unsigned>(closest ? LeafOutcome::beyond : LeafOutcome::rejected)], 20u);
  }
}

// With the bound by opacity: entries leave, rounds are preloaded up to the end, and the end never moves back.
TEST(RoundHits, OfABoundedReaderAreThoseOfTheTracer) {
  std::mt19937 random(5);
  const RoundRules rules(Tracing::multi, AnyHit::immediate, 6, true, false);
  std::size_t hidden = 0, shortened = 0;
  for (int ray = 0; ray < 200; ++ray) {
    Hits tracer(rules, {OpacityBound::on, 0.001f}), reader(rules);
    float end = std::numeric_limits<float>::infinity();
    for (int round = 0; round < 3; ++round) {
      const float before = end;
      const std::size_t held_back = tracer.evictions().size();
      const std::size_t preloaded = tracer.begin_round(round == 0 ? 1.0f : 0.5f, end);
      shortened += preloaded < rules.preloaded(held_back) ? 1 : 0;
      reader.begin_round(preloaded);
      float t_max = end;
      for (int i = 0; i < 20; ++i) {
        const TestHit hit{static_cast<float>(random() % 40), 20 * round + i,
                          static_cast<std::uint32_t>(random() % 4000)};
        if (hit.t > t_max) continue;
        const std::uint64_t held = reader.k_buffer().size();
        const Hits::Taken taken = tracer.take(hit, t_max, end);
        ASSERT_LE(t_max, end);
        ASSERT_LE(end, before);
        ASSERT_LT(taken.hidden, std::max<std::uint64_t>(RoundRules::held_after(taken.outcome, held), 1));
        reader.take(hit, taken, held - 1);
        ASSERT_EQ(reader.k_buffer().entries(), tracer.k_buffer().entries());
        ASSERT_EQ(reader.evictions(), tracer.evictions());
        hidden += taken.hidden;
        std::uint32_t sum = 0;
        for (const TestHit& entry : tracer.k_buffer().entries()) sum += entry.opacity;
        const std::uint32_t without_last = sum - tracer.k_buffer().entries().back().opacity;
        ASSERT_LT(without_last, 10240u) << "an entry is left behind the end";
      }
    }
  }
  EXPECT_GT(hidden, 500u);
  EXPECT_GT(shortened, 20u);
}

TEST(RoundHits, NothingIsLostBetweenRounds) {
  const RoundRules rules(Tracing::multi, AnyHit::immediate, 3, true, false);
  Hits hits(rules);
  float t_max = std::numeric_limits<float>::infinity(), end = t_max;
  hits.begin_round(1.0f, end);
  for (int i = 9; i >= 0; --i) (void)hits.take({static_cast<float>(i), i}, t_max, end);
  EXPECT_EQ(hits.evictions().size(), 7u);
  int next = 0;
  for (const unsigned held : {3u, 3u, 3u, 1u}) {
    if (next != 0) {
      EXPECT_EQ(hits.begin_round(1.0f, end), held);
    }
    ASSERT_EQ(hits.k_buffer().size(), held);
    for (const TestHit& hit : hits.k_buffer().entries()) EXPECT_EQ(hit.id, next++);
  }
  EXPECT_EQ(hits.begin_round(1.0f, end), 0u);
}

// An unsorted buffer keeps the same hits as a sorted one; which of them a reader takes out is told by their distances.
TEST(RoundHits, OfAListAreTheNearestOnes) {
  std::mt19937 random(4);
  const RoundRules rules(Tracing::list, AnyHit::immediate, 6, false, true);
  Hits tracer(rules), reader(rules);
  float t_max = std::numeric_limits<float>::infinity(), end = t_max;
  std::vector<TestHit> all;
  for (int i = 0; i < 60; ++i) {
    const TestHit hit{static_cast<float>(random() % 40), i};
    all.push_back(hit);
    if (hit.t > t_max) continue;
    const auto& held = reader.k_buffer().entries();
    const auto last = static_cast<std::size_t>(std::max_element(held.begin(), held.end()) - held.begin());
    reader.take(hit, tracer.take(hit, t_max, end), last);
  }
  std::sort(all.begin(), all.end());
  all.resize(6);
  std::vector<TestHit> kept = reader.k_buffer().entries();
  std::sort(kept.begin(), kept.end());
  tracer.end_round();
  EXPECT_EQ(kept, all);
  EXPECT_EQ(tracer.k_buffer().entries(), all);
  EXPECT_EQ(t_max, all.back().t);
}

TEST(CheckpointLists, WhatARoundWritesTheNextOneReads) {
  for (const CheckpointOrder order : {CheckpointOrder::fifo, CheckpointOrder::lifo}) {
    CheckpointLists<int> lists(order, 0, 2);
    lists.begin_ray();
    lists.begin_round(false, {});
    EXPECT_FALSE(lists.more());
    lists.write(7);
    EXPECT_FALSE(lists.full());
    lists.write(8);
    EXPECT_TRUE(lists.full());
    EXPECT_EQ(lists.held(), 2u);
    lists.begin_round(true, {});
    EXPECT_FALSE(lists.full());
    EXPECT_EQ(lists.read(), order == CheckpointOrder::fifo ? 7 : 8);
    lists.write(9);
    EXPECT_EQ(lists.read(), order == CheckpointOrder::fifo ? 8 : 7);
    EXPECT_FALSE(lists.more());
    lists.begin_round(false, {});  // at the root again: what was written is dropped
    EXPECT_FALSE(lists.more());
    EXPECT_EQ(lists.held(), 0u);
  }
}

}  // namespace
}  // namespace grtx::traces
