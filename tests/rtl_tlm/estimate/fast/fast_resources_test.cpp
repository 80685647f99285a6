// The resources of fast mode give what plain tables give.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "grtx/rtl_tlm/estimate/fast/bank_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/intersection_pipelines.h"
#include "grtx/rtl_tlm/estimate/fast/near_cycle.h"
#include "grtx/rtl_tlm/estimate/fast/place_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/place_ring.h"
#include "grtx/rtl_tlm/estimate/fast/port_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/response_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/slot_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/span_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/turn_calendar.h"
#include "parameter_names.h"

namespace grtx::sim {
namespace {

/// Pipelines that a test holds for 7 cycles, with a latency of 5.
fast::IntersectionPipelines held_for_seven(unsigned count) {
  modules::IntersectionUnit::Config config;
  config.count = count;
  config.interval = 7;
  config.latency = 5;
  return fast::IntersectionPipelines(config);
}

// With instances that are entered in 7 cycles each: what came with data that is there later held back what came after
// it.
TEST(IntersectionPipelinesTest, ATestInAGapBeforeALaterOneDoesNotWaitForIt) {
  fast::IntersectionPipelines pipelines = held_for_seven(1);
  EXPECT_EQ(pipelines.test(100, 1), 101U + 5);
  EXPECT_EQ(pipelines.test(10, 1), 11U + 5);
  EXPECT_EQ(pipelines.test(10, 2), 18U + 7 + 5) << "the second test seven cycles later";
  EXPECT_EQ(pipelines.test(95, 1), 108U + 5) << "six cycles are too few";
  EXPECT_EQ(pipelines.counters().queue_cycles, (18U - 11) + (108 - 96));
  EXPECT_EQ(pipelines.counters().busy_cycles, 5U * 7);
}

TEST(IntersectionPipelinesTest, TheNextTestTakesThePipelineThatIsFreeFirst) {
  fast::IntersectionPipelines pipelines = held_for_seven(2);
  EXPECT_EQ(pipelines.test(10, 1), 11U + 5);
  EXPECT_EQ(pipelines.test(12, 1), 13U + 5);
  EXPECT_EQ(pipelines.test(12, 1), 18U + 5);
}

class SpanCalendarTest : public ::testing::TestWithParam<unsigned> {};

TEST_P(SpanCalendarTest, EqualsASetOfBusyCycles) {
  const unsigned span = GetParam();
  SpanCalendar calendar(span);
  std::set<Cycle> busy;
  std::mt19937_64 random(5);
  Cycle now = 0;
  for (int step = 0; step < 5000; ++step) {
    if (step % 40 == 39) {
      now += random() % (400 * span);  // so that no backlog outgrows what is kept
      calendar.advance(now);
    }
    const Cycle wish = now + random() % 300;
    Cycle first = wish;
    for (unsigned i = 0; i < span;) {
      if (busy.contains(first + i)) {
        first += i + 1;
        i = 0;
      } else {
        ++i;
      }
    }
    for (unsigned i = 0; i < span; ++i) busy.insert(first + i);
    ASSERT_EQ(calendar.reserve(wish), first) << "step " << step << " wish " << wish;
  }
}

INSTANTIATE_TEST_SUITE_P(Spans, SpanCalendarTest, ::testing::Values(1u, 4u, 10u, 64u, 150u), grtx::test::PrintedName{});

TEST(SpanCalendarLimits, WhatLiesFarAheadComesInOrder) {
  SpanCalendar calendar(4);
  const Cycle first = calendar.reserve(1000000);
  EXPECT_EQ(first, 1000000u);
  EXPECT_EQ(calendar.reserve(1000000), first + 4);
  EXPECT_EQ(calendar.reserve(7), 7u);
}

// With bursts of 10,000 clocks: whoever came when the time had come near got the same clocks once more.
TEST(SpanCalendarLimits, WhatWasGivenFarAheadIsGivenTwice) {
  for (const unsigned span : {100u, 9000u, 10000u, 20000u}) {
    SpanCalendar calendar(span);
    std::set<Cycle> starts;
    std::mt19937_64 random(span);
    Cycle now = 0;
    for (int step = 0; step < 400; ++step) {
      now += random() % (step % 50 == 0 ? 40 * span : span);
      calendar.advance(now);
      const Cycle start = calendar.reserve(now + random() % (3 * span));
      const auto next = starts.lower_bound(start);
      if (next != starts.end()) {
        ASSERT_GE(*next, start + span) << "span " << span << " step " << step;
      }
      if (next != starts.begin()) {
        ASSERT_GE(start, *std::prev(next) + span) << "span " << span << " step " << step;
      }
      starts.insert(start);
    }
  }
}

TEST(PortCalendarLimits, WhatWasGivenFarAheadIsGivenTwice) {
  PortCalendar port;
  SlotCalendar slots(3);
  std::set<Cycle> given;
  std::map<Cycle, unsigned> used;
  std::mt19937_64 random(3);
  Cycle now = 0;
  for (int step = 0; step < 20000; ++step) {
    if (step % 20 == 19) {
      now += random() % (step % 1000 == 999 ? 50000 : 60);
      port.advance(now);
      slots.advance(now);
    }
    const Cycle wish = now + random() % (step % 3 == 0 ? 30000 : 100);
    ASSERT_TRUE(given.insert(port.reserve(wish)).second) << "step " << step;
    ASSERT_LE(++used[slots.reserve(wish)], 3u) << "step " << step;
  }
}

TEST(BankCalendarTest, EqualsASetOfBanksAndCycles) {
  for (const unsigned banks : {1u, 3u, 4u, 64u}) {
    BankCalendar calendar(banks);
    std::set<std::pair<unsigned, Cycle>> busy;
    std::mt19937_64 random(banks);
    Cycle now = 0;
    for (int step = 0; step < 20000; ++step) {
      if (step % 50 == 49) {
        now += random() % 100;
        calendar.advance(now);
      }
      const std::uint64_t sector = random() % 1000;
      const unsigned bank = calendar.bank(sector);
      ASSERT_EQ(bank, sector % banks);
      Cycle wish = now + random() % 60;
      const Cycle got = calendar.reserve(bank, wish);
      while (!busy.insert({bank, wish}).second) ++wish;
      ASSERT_EQ(got, wish) << "step " << step;
    }
  }
}

TEST(BankCalendarTest, RunsAreTheBanksOfConsecutiveSectorsInConsecutiveCycles) {
  for (const unsigned banks : {1u, 3u, 4u, 64u}) {
    BankCalendar calendar(banks);
    std::set<std::pair<unsigned, Cycle>> busy;
    std::mt19937_64 random(banks);
    Cycle now = 0;
    unsigned taken = 0, refused = 0;
    for (int step = 0; step < 20000; ++step) {
      if (step % 50 == 49) {
        now += random() % 100;
        calendar.advance(now);
      }
      const unsigned count = 1 + static_cast<unsigned>(random() % 8);
      const unsigned bank = static_cast<unsigned>(random() % banks);
      const Cycle from = now + random() % 150;
      bool free = true;
      for (unsigned i = 0; i < count; ++i) free = free && !busy.contains({(bank + i) % banks, from + i});
      const bool shares = step % 7 == 0;
      if (shares) {
        calendar.share_run(bank, from, count);
      } else {
        ASSERT_EQ(calendar.reserve_run(bank, from, count), free) << "step " << step;
        ++(free ? taken : refused);
      }
      for (unsigned i = 0; i < count && (free || shares); ++i) busy.insert({(bank + i) % banks, from + i});
    }
    EXPECT_GT(taken, 1000u);
    EXPECT_GT(refused, 1000u);
  }
}

TEST(PortCalendarTest, RunsAreTakenWhenEachOfTheirCyclesIsFree) {
  PortCalendar calendar;
  std::set<Cycle> busy;
  std::mt19937_64 random(4);
  Cycle now = 0;
  unsigned taken = 0;
  for (int step = 0; step < 20000; ++step) {
    if (step % 50 == 49) {
      now += random() % 300;
      calendar.advance(now);
    }
    Cycle from = now + random() % 200;
    if (step % 2 == 0) {
      const Cycle got = calendar.reserve(from);
      while (!busy.insert(from).second) ++from;
      ASSERT_EQ(got, from) << "step " << step;
      continue;
    }
    const unsigned count = 1 + static_cast<unsigned>(random() % 5);
    bool free = true;
    for (unsigned i = 0; i < count; ++i) free = free && !busy.contains(from + i);
    const bool got = calendar.reserve_run(from, count);
    ASSERT_TRUE(free || !got) << "step " << step;
    ASSERT_TRUE(got || !free || from % 64 + count > 64) << "step " << step;  // no run reaches into the next word
    for (unsigned i = 0; i < count && got; ++i) busy.insert(from + i);
    taken += got;
  }
  EXPECT_GT(taken, 1000u);
}

// The port itself, cycle by cycle: what has been due longest first, a hit before a fill of the same cycle. Fills are
// reserved long before they come, hits when they come; all that the calendar cannot do is to tell fills of hits that
// were not known when they reserved.
TEST(ResponseCalendarTest, GivesHitsWhatAQueueOfHitsAndOneOfFillsGiveThem) {
  std::mt19937_64 random(11);
  unsigned waited = 0, passed = 0;
  for (int round = 0; round < 200; ++round) {
    ResponseCalendar calendar;
    constexpr Cycle kCycles = 300;
    const unsigned load = 1 + static_cast<unsigned>(random() % 10);  // tenths of the cycles in which something is due
    std::vector<bool> hit_due(kCycles), fill_due(kCycles);
    for (Cycle at = 0; at < kCycles; ++at) {
      hit_due[at] = random() % 20 < load;
      fill_due[at] = random() % 20 < load;
    }
    for (Cycle at = 0; at < kCycles; ++at) {
      if (fill_due[at]) {
        EXPECT_GE(calendar.reserve_fill(at), at);
      }
    }
    std::deque<Cycle> hits, fills;
    std::vector<Cycle> hit_left;
    for (Cycle now = 0; now < 3 * kCycles; ++now) {
      if (now < kCycles && hit_due[now]) hits.push_back(now);
      if (now < kCycles && fill_due[now]) fills.push_back(now);
      if (!hits.empty() && (fills.empty() || hits.front() <= fills.front())) {
        passed += !fills.empty();
        waited += now > hits.front();
        hits.pop_front();
        hit_left.push_back(now);
      } else if (!fills.empty()) {
        fills.pop_front();
      }
    }
    std::size_t i = 0;
    for (Cycle at = 0; at < kCycles; ++at) {
      if (!hit_due[at]) continue;
      ASSERT_EQ(calendar.reserve_hit(at), hit_left[i]) << "round " << round << " due " << at;
      ++i;
    }
  }
  EXPECT_GT(waited, 1000u);
  EXPECT_GT(passed, 1000u);
}

TEST(ResponseCalendarTest, RunsAreTakenWhereNobodyIs) {
  ResponseCalendar calendar;
  EXPECT_EQ(calendar.reserve_fill(10), 10u);
  EXPECT_FALSE(calendar.reserve_run(11, 2, true)) << "10 is taken";
  EXPECT_TRUE(calendar.reserve_run(14, 3, false));
  EXPECT_EQ(calendar.reserve_hit(12), 12u) << "a hit goes before a fill that is due in the same cycle";
  EXPECT_EQ(calendar.reserve_fill(11), 11u);
  EXPECT_EQ(calendar.reserve_fill(12), 16u) << "the three fills are one cycle later";
  EXPECT_TRUE(calendar.reserve_run(21, 2, true));
  EXPECT_EQ(calendar.reserve_hit(20), 22u) << "hits keep their places";
  calendar.advance(100000);
  EXPECT_EQ(calendar.reserve_hit(5), 100000u / 64 * 64) << "past cycles are not given";
}

// Whoever comes waits for one item of each of the others at most, no cycle serves two, and all who have items behind it
// are told.
TEST(TurnCalendarTest, NobodyWaitsForTwoItemsOfAnother) {
  TurnCalendar calendar;
  std::map<Cycle, unsigned> owner;
  std::mt19937_64 random(6);
  Cycle now = 0;
  unsigned displaced = 0, several = 0, waited = 0;
  for (int step = 0; step < 20000; ++step) {
    if (step % 40 == 39) {
      now += 45;
      calendar.advance(now);
    }
    const unsigned client = static_cast<unsigned>(random() % 5) * 50;
    const Cycle from = now + random() % 60;
    std::vector<unsigned> delayed;
    const Cycle at = calendar.reserve(from, client, [&](unsigned other) { delayed.push_back(other); });
    ASSERT_GE(at, from);
    std::map<unsigned, unsigned> before;
    for (Cycle earlier = from; earlier < at; ++earlier) {
      ASSERT_TRUE(owner.contains(earlier)) << "step " << step << ": cycle " << earlier << " was free";
      if (owner[earlier] == client) continue;
      ASSERT_EQ(++before[owner[earlier]], 1u) << "step " << step << " at " << earlier;
    }
    waited += at > from;
    if (!owner.contains(at)) {
      ASSERT_TRUE(delayed.empty()) << "step " << step;
    } else {
      ++displaced;
      ASSERT_NE(owner[at], client);
      ASSERT_EQ(before[owner[at]], 1u) << "step " << step << ": it had not had its turn";
      std::set<unsigned> behind;
      Cycle free = at;
      for (; owner.contains(free); ++free) behind.insert(owner[free]);
      behind.erase(client);
      ASSERT_EQ(delayed.size(), behind.size()) << "step " << step;
      ASSERT_EQ(std::set<unsigned>(delayed.begin(), delayed.end()), behind) << "step " << step;
      several += behind.size() > 1;
      owner[free] = owner[at];
    }
    owner[at] = client;
  }
  EXPECT_GT(displaced, 1000u);
  EXPECT_GT(several, 300u);
  EXPECT_GT(waited, 2000u);
}

TEST(TurnCalendarTest, WhatLiesFarAheadComesInOrder) {
  TurnCalendar calendar;
  const auto nobody = [](unsigned) { FAIL(); };
  EXPECT_EQ(calendar.reserve(1000000, 3, nobody), 1000000u);
  EXPECT_EQ(calendar.reserve(1000000, 3, nobody), 1000001u);
  EXPECT_EQ(calendar.reserve(7, 3, nobody), 7u);
}

TEST(PlaceCalendarTest, EqualsASortedListOfThoseInside) {
  constexpr std::size_t kPlaces = 20;
  PlaceCalendar calendar(kPlaces);
  std::multiset<Cycle> inside;
  std::mt19937_64 random(9);
  Cycle now = 0;
  std::size_t waited = 0;
  for (int step = 0; step < 20000; ++step) {
    now += random() % 20;
    Cycle room = now;
    inside.erase(inside.begin(), inside.upper_bound(room));
    while (inside.size() >= kPlaces) {
      room = *inside.begin();
      inside.erase(inside.begin(), inside.upper_bound(room));
    }
    waited += room > now ? 1 : 0;
    ASSERT_EQ(calendar.room(now), room) << "step " << step;
    now = room;
    const Cycle until = now + 1 + random() % (step % 100 == 0 ? 5000 : 400);
    const unsigned count = step % 10 == 0 ? 3 : 1;
    calendar.take(until, count);
    for (unsigned i = 0; i < count; ++i) inside.insert(until);
  }
  EXPECT_GT(waited, 1000u);
}

TEST(PlaceRingTest, HasRoomWhenTheOneSoManyPlacesAgoHasLeft) {
  PlaceRing ring(2);
  EXPECT_EQ(ring.room(), 0u);
  ring.take(10);
  EXPECT_EQ(ring.room(), 0u);
  ring.take(7);
  EXPECT_EQ(ring.room(), 10u);
  ring.take(30);
  EXPECT_EQ(ring.room(), 7u);
}

TEST(PlaceRingTest, HasRoomForSeveralWhenAsManyHaveLeft) {
  PlaceRing ring(3);
  ring.take(10, 2);
  ring.take(25);
  EXPECT_EQ(ring.room(1), 10u);
  EXPECT_EQ(ring.room(2), 10u);
  EXPECT_EQ(ring.room(3), 25u);
  EXPECT_EQ(ring.room(9), 25u) << "more than there are places: for as many as there are";
  ring.take(40);
  EXPECT_EQ(ring.room(2), 25u);
}

TEST(NearCycleTest, IsTheCycleWithinReachOfThePresent) {
  for (const Cycle now : {Cycle{0}, Cycle{5000}, Cycle{1} << 32, (Cycle{7} << 32) - 3}) {
    for (const Cycle ahead : {Cycle{0}, Cycle{1}, Cycle{123456}, NearCycle::kReach - 1}) {
      EXPECT_EQ(NearCycle(now + ahead).at(now), now + ahead);
      if (ahead <= now) {
        EXPECT_EQ(NearCycle(now - ahead).at(now), now - ahead);
      }
    }
  }
}

// One round of a building (k = 1024, every byte charged) hung: the count of those who leave in a cycle had 16 bits.
TEST(PlaceCalendar, ManyMoreThanThereAreLeaveInOneCycle) {
  PlaceCalendar places(64);
  places.take(100, 40000);
  places.take(100, 40000);
  EXPECT_EQ(places.room(10), 100U);
  EXPECT_FALSE(places.full(100));
}

}  // namespace
}  // namespace grtx::sim
