// ClockDomain: ticks fall on the integer grid, bookings persist, idle cycles are skipped and skipping changes nothing.
#include "modules/clock_domain.h"

#include <gmock/gmock.h>

#include <vector>

#include "systemc_fixture.h"

namespace grtx::modules {
namespace {

using ::testing::ElementsAre;

class ClockDomainTest : public SystemCTest {};

TEST_F(ClockDomainTest, EveryBookedCycleTicksOnceWhateverTheOrderOfTheRequests) {
  ClockDomain clock("clock", 1365.0);
  std::vector<Cycle> ticks;
  TickProcess process("process", clock, [&](Cycle now) {
    ticks.push_back(now);
    EXPECT_EQ(sc_core::sc_time_stamp().value(), now * clock.period_fs());
  });
  for (const Cycle cycle : {5000u, 7u, 3u, 1023u, 1024u, 1025u, 7u, 0u, 100000u, 5000u}) clock.request(cycle);
  clock.request(kNever);
  EXPECT_TRUE(run_until_quiet(clock, 200000));
  EXPECT_THAT(ticks, ElementsAre(0, 3, 7, 1023, 1024, 1025, 5000, 100000));
  EXPECT_EQ(clock.ticks(), 8u);
}

TEST_F(ClockDomainTest, RequestsMadeInATickNeverFireInThePast) {
  ClockDomain clock("clock", 1000.0);
  std::vector<Cycle> ticks;
  TickProcess process("process", clock, [&](Cycle now) {
    ticks.push_back(now);
    if (now == 10) {
      clock.request(4);     // past: the next edge
      clock.request(3000);  // beyond the wheel
      clock.request(12);    // nearer than what is booked
    }
    if (now == 12) clock.request(1036);  // the last cycle of the wheel's window is 12 + 1023
  });
  clock.request(10);
  EXPECT_TRUE(run_until_quiet(clock, 10000));
  EXPECT_THAT(ticks, ElementsAre(10, 11, 12, 1036, 3000));
}

TEST_F(ClockDomainTest, RandomBookingsAgreeWithASortedSet) {
  ClockDomain clock("clock", 3500.0);
  std::vector<Cycle> ticks;
  std::set<Cycle> expected;
  std::uint64_t state = 7;
  const auto random = [&](std::uint64_t bound) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (state >> 33) % bound;
  };
  TickProcess process("process", clock, [&](Cycle now) {
    ticks.push_back(now);
    ASSERT_EQ(*expected.lower_bound(now), now);
    for (std::uint64_t i = random(3); i > 0 && ticks.size() < 3000; --i) {
      const Cycle cycle = now + 1 + random(random(10) == 0 ? 4000 : 60);
      expected.insert(cycle);
      clock.request(cycle);
    }
    if (ticks.size() < 3000 && expected.upper_bound(now) == expected.end()) {
      expected.insert(now + 2);
      clock.request(now + 2);
    }
  });
  expected.insert(1);
  clock.request(1);
  EXPECT_TRUE(run_until_quiet(clock, 10'000'000));
  EXPECT_GE(ticks.size(), 3000u);
  EXPECT_TRUE(std::equal(ticks.begin(), ticks.end(), expected.begin(), expected.end()));
}

TEST_F(ClockDomainTest, ACallFromOutsideIsVisibleStrictlyLater) {
  ClockDomain core("core", 1000.0);
  ClockDomain memory("memory", 2000.0);  // every second edge coincides
  std::vector<Cycle> seen;
  TickProcess outside("outside", memory, [&](Cycle now) {
    const Cycle edge = core.edge_after();
    EXPECT_EQ(edge, now / 2 + 1);
    core.request(edge);
  });
  TickProcess inside("inside", core, [&](Cycle now) { seen.push_back(now); });
  for (Cycle c : {4u, 5u, 6u}) memory.request(c);
  run(core, 20);
  EXPECT_THAT(seen, ElementsAre(3, 4));
}

// A module that the domain calls: the clock ticks when it is due, and in no cycle besides.
struct Sleeper {
  explicit Sleeper(ClockDomain& domain)
      : clock(domain),
        alarm(Alarm::without_process(domain, this, [](void* module) { static_cast<Sleeper*>(module)->tick(); })) {}
  ClockDomain& clock;
  Alarm alarm;
  std::vector<Cycle> wishes, seen;
  void tick() {
    seen.push_back(clock.cycle());
    if (seen.size() < wishes.size()) alarm.request(wishes[seen.size()]);
  }
};

TEST_F(ClockDomainTest, TicksOnlyInTheCyclesOfACalledAlarm) {
  ClockDomain clock("clock", 1365.0);
  Sleeper sleeper(clock);
  sleeper.wishes = {3, 4, 40, 2000, 2001};
  sleeper.alarm.request(3);
  run(clock, 3000);
  EXPECT_EQ(sleeper.seen, sleeper.wishes);
  EXPECT_EQ(clock.ticks(), 5u);
}

TEST_F(ClockDomainTest, ABookingOfTheNextCycleFromInsideATickIsKept) {
  ClockDomain clock("clock", 1365.0);
  Alarm alarm = Alarm::without_process(clock, &clock, [](void* module) {
    auto& domain = *static_cast<ClockDomain*>(module);
    domain.request(domain.cycle() + 1);
  });
  alarm.request(7);
  run(clock, 100);
  EXPECT_EQ(clock.ticks(), 2u);
  EXPECT_EQ(clock.cycle(), 8u);
}

TEST_F(ClockDomainTest, WithoutIdleSkipEveryCycleTicks) {
  ClockDomain clock("clock", 1365.0, false);
  Cycle last = 0;
  TickProcess process("process", clock, [&](Cycle now) { last = now; });
  clock.request(0);
  run(clock, 100);
  EXPECT_GE(last, 99u);
  EXPECT_EQ(clock.ticks(), last + 1);
}

}  // namespace
}  // namespace grtx::modules
