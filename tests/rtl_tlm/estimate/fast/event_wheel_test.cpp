// A wheel hands out every number once, in the cycle in which it is due, near and far ones alike.
#include "grtx/rtl_tlm/estimate/fast/event_wheel.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

namespace grtx::sim {
namespace {

using Number = EventWheel::Number;

TEST(EventWheel, EqualsASortedMap) {
  constexpr std::size_t kNumbers = 300;
  EventWheel wheel(kNumbers);
  std::map<Cycle, std::set<Number>> due;
  std::mt19937_64 random(3);
  const auto add = [&](Number number) {
    const Cycle at = wheel.now() + 1 + random() % (random() % 10 == 0 ? 40000 : 500);
    wheel.add(at, number);
    due[at].insert(number);
  };
  for (Number number = 0; number < kNumbers; ++number) add(number);
  int left = 30000;
  std::size_t steps = 0;
  Cycle last = 0;
  wheel.run([&](Number number) {
    ASSERT_FALSE(due.empty());
    const auto first = due.begin();
    ASSERT_EQ(wheel.now(), first->first);
    steps += wheel.now() != last ? 1 : 0;
    last = wheel.now();
    ASSERT_EQ(first->second.erase(number), 1U);
    if (first->second.empty()) due.erase(first);
    if (--left > 0 && random() % 4 != 0) add(number);
    if (left > 0 && random() % 3 == 0) {  // another one, if it is not in the wheel
      const auto other = static_cast<Number>(random() % kNumbers);
      for (const auto& [at, numbers] : due) {
        if (numbers.contains(other)) return;
      }
      add(other);
    }
  });
  EXPECT_TRUE(due.empty());
  EXPECT_EQ(wheel.steps(), steps);
  EXPECT_LT(left, 29000);
}

TEST(EventWheel, WhatIsAlreadyPastIsDueInTheNextCycle) {
  EventWheel wheel(3);
  wheel.add(100, 0);
  std::map<Number, Cycle> seen;
  wheel.run([&](Number number) {
    seen[number] = wheel.now();
    if (number != 0) return;
    wheel.add(60, 1);
    wheel.add(100, 2);
  });
  EXPECT_EQ(seen, (std::map<Number, Cycle>{{0, 100}, {1, 101}, {2, 101}}));
}

}  // namespace
}  // namespace grtx::sim
