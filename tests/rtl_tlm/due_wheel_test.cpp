// A wheel hands out every number once, in the cycle in which it is due, near and far ones alike.
#include "rtl_tlm/fast/due_wheel.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

namespace grtx::tlm {
namespace {

TEST(DueWheel, EqualsASortedMap) {
  constexpr std::size_t kNumbers = 300;
  DueWheel wheel(kNumbers);
  std::map<Cycle, std::set<DueWheel::Number>> due;
  std::vector<DueWheel::Number> free;
  for (std::size_t i = 0; i < kNumbers; ++i) free.push_back(static_cast<DueWheel::Number>(i));
  std::mt19937_64 random(3);
  Cycle now = 5;
  for (int step = 0; step < 30000; ++step) {
    const bool busy = free.size() < kNumbers;
    EXPECT_EQ(wheel.empty(), !busy);
    ASSERT_EQ(wheel.next(), busy ? due.begin()->first : modules::kNever);
    if (!free.empty() && (random() % 3 != 0 || !busy)) {
      const std::size_t pick = random() % free.size();
      const DueWheel::Number number = free[pick];
      free.erase(free.begin() + static_cast<std::ptrdiff_t>(pick));
      const Cycle at = now + 1 + random() % (random() % 10 == 0 ? 20000 : 500);
      wheel.add(now, at, number);
      due[at].insert(number);
      continue;
    }
    now = wheel.next();
    const DueWheel::Number peeked = wheel.peek();
    EXPECT_TRUE(peeked == DueWheel::kNone || due.begin()->second.contains(peeked));
    std::set<DueWheel::Number> taken;
    wheel.take(now, [&](DueWheel::Number number) { EXPECT_TRUE(taken.insert(number).second); });
    ASSERT_EQ(taken, due.begin()->second) << "cycle " << now;
    free.insert(free.end(), taken.begin(), taken.end());
    due.erase(due.begin());
  }
}

TEST(DueWheel, WhatIsAlreadyPastIsDueInTheNextCycle) {
  DueWheel wheel(4);
  wheel.add(0, 100, 0);
  wheel.add(0, 5000, 1);
  wheel.take(100, [](DueWheel::Number) {});
  wheel.add(50, 60, 2);
  EXPECT_EQ(wheel.next(), 101U);
}

}  // namespace
}  // namespace grtx::tlm
