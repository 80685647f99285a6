// A calendar gives what a plain table of served items gives: the first cycle from the wished one on with a place.
#include "grtx/rtl_tlm/estimate/fast/slot_calendar.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "grtx/rtl_tlm/estimate/fast/port_calendar.h"
#include "parameter_names.h"

namespace grtx::sim {
namespace {

struct Shape {
  unsigned places, width;
  friend void PrintTo(const Shape& s, std::ostream* out) { *out << s.places << " in " << s.width; }
};

class SlotCalendarTest : public ::testing::TestWithParam<Shape> {};

TEST_P(SlotCalendarTest, EqualsAPlainTable) {
  const auto [places, width] = GetParam();
  SlotCalendar calendar(places, width);
  std::map<Cycle, unsigned> used;  // by slot of `width` cycles
  std::mt19937_64 random(7);
  Cycle now = 0;
  for (int step = 0; step < 20000; ++step) {
    if (step % 50 == 49) {
      now += random() % 120 * width;
      calendar.advance(now);
    }
    const Cycle wish = now + random() % 200;
    Cycle slot = (wish + width - 1) / width;
    while (used[slot] == places) ++slot;
    ++used[slot];
    ASSERT_EQ(calendar.reserve(wish), slot * width) << "step " << step << " wish " << wish;
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, SlotCalendarTest,
                         ::testing::Values(Shape{1, 1}, Shape{4, 1}, Shape{1, 4}, Shape{3, 2}, Shape{300, 1}),
                         grtx::test::PrintedName{});

TEST(PortCalendar, EqualsASlotCalendarOfOnePlace) {
  PortCalendar port;
  SlotCalendar slots;
  std::mt19937_64 random(11);
  Cycle now = 0;
  for (int step = 0; step < 20000; ++step) {
    if (step % 50 == 49) {
      now += random() % 120;
      port.advance(now);
      slots.advance(now);
    }
    const Cycle wish = now + random() % (step % 1000 == 0 ? 20000 : 100);  // some beyond what is kept
    ASSERT_EQ(port.reserve(wish), slots.reserve(wish)) << "step " << step << " wish " << wish;
  }
}

TEST(SlotCalendarLimits, PastCyclesAreNotGivenAndFarOnesComeInOrder) {
  SlotCalendar calendar;
  calendar.advance(1000);
  EXPECT_GE(calendar.reserve(3), 960U) << "whole words of 64 cycles pass";
  const Cycle far = calendar.reserve(1'000'000);
  EXPECT_EQ(far, 1'000'000U);
  EXPECT_EQ(calendar.reserve(999'000), 1'000'001U) << "beyond the window the order of calls counts";
}

}  // namespace
}  // namespace grtx::sim
