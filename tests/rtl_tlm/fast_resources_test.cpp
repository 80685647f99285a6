// The resources of fast mode give what plain tables give.
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "rtl_tlm/fast/bank_calendar.h"
#include "rtl_tlm/fast/near_cycle.h"
#include "rtl_tlm/fast/place_calendar.h"
#include "rtl_tlm/fast/place_ring.h"
#include "rtl_tlm/fast/span_calendar.h"

namespace grtx::tlm {
namespace {

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

INSTANTIATE_TEST_SUITE_P(Spans, SpanCalendarTest, ::testing::Values(1u, 4u, 10u, 64u, 150u));

TEST(SpanCalendarLimits, WhatLiesFarAheadComesInOrder) {
  SpanCalendar calendar(4);
  const Cycle first = calendar.reserve(1000000);
  EXPECT_EQ(first, 1000000u);
  EXPECT_EQ(calendar.reserve(1000000), first + 4);
  EXPECT_EQ(calendar.reserve(7), 7u);
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
    calendar.take(until);
    inside.insert(until);
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

}  // namespace
}  // namespace grtx::tlm
