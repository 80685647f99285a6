// What a DRAM channel and a cache of fast mode reserve, against lists that are searched from end to end.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "grtx/rtl_tlm/estimate/fast/activate_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/arrivals.h"
#include "grtx/rtl_tlm/estimate/fast/column_calendar.h"
#include "parameter_names.h"

namespace grtx::sim {
namespace {

using modules::DramTiming;

TEST(ActivateCalendarTest, WithoutAWindowIsTheFirstClockFarEnoughFromAllOthers) {
  DramTiming timing;
  timing.rrd = 7;
  timing.faw = 0;
  ActivateCalendar calendar(timing);
  std::mt19937 random(3);
  std::vector<Cycle> taken;
  Cycle now = 1000;
  for (int i = 0; i < 5000; ++i) {
    if (i % 16 == 0) calendar.advance(now += random() % 260);
    const Cycle from = now + random() % 300;
    Cycle expected = from;
    while (std::ranges::any_of(taken, [&](Cycle at) { return at < expected + 7 && expected < at + 7; })) ++expected;
    ASSERT_EQ(calendar.reserve(from, static_cast<unsigned>(random() % 4)), expected) << i;
    taken.push_back(expected);
  }
}

struct Burst {
  Cycle place;
  unsigned group;
  enum { read, write, joined } way;
};

/// The rules of ColumnCalendar, with every burst that there ever was.
class AllBursts {
 public:
  explicit AllBursts(const DramTiming& timing) : t_(timing) {}
  Cycle read(Cycle from, unsigned group) {
    const Cycle at = add({from / t_.ccd, group, Burst::read});
    last_read_ = std::max(last_read_, at);
    return std::max(from, at * t_.ccd);
  }
  Cycle write(Cycle from, unsigned group) {
    const Burst* next = nullptr;
    for (const Burst& burst : bursts_) {
      if (burst.way != Burst::write || burst.place < from / t_.ccd) continue;
      if (next == nullptr || burst.place < next->place) next = &burst;
    }
    if (next != nullptr) {
      add({next->place, group, Burst::joined});
      return std::max(from, next->place * t_.ccd);
    }
    const Cycle behind = std::max(from / t_.ccd, last_read_ + places(t_.read_to_write()));
    return std::max(from, add({behind, group, Burst::write}) * t_.ccd);
  }

 private:
  Cycle places(Cycle clocks) const { return std::max<Cycle>(1, (clocks + t_.ccd / 2) / t_.ccd); }
  Cycle distance(const Burst& first, const Burst& then) const {
    const bool same = first.group == then.group;
    if (first.way == then.way || first.way == Burst::joined || then.way == Burst::joined) {
      return same ? places(t_.ccd_of_group()) : 1;
    }
    if (first.way == Burst::read) return places(t_.read_to_write());
    return places(same ? t_.write_to_read_of_group() : t_.write_to_read());
  }
  Cycle add(Burst burst) {
    const auto close = [&](const Burst& other) {
      return other.place <= burst.place ? other.place + distance(other, burst) > burst.place
                                        : burst.place + distance(burst, other) > other.place;
    };
    while (std::ranges::any_of(bursts_, close)) ++burst.place;
    bursts_.push_back(burst);
    return burst.place;
  }

  DramTiming t_;
  Cycle last_read_ = 0;
  std::vector<Burst> bursts_;
};

class ColumnCalendarTest : public ::testing::TestWithParam<unsigned> {};

TEST_P(ColumnCalendarTest, IsTheFirstPlaceThatKeepsItsDistances) {
  DramTiming timing;
  timing.ccd_l = GetParam();
  timing.cdlr_l = GetParam() == 0 ? 0 : timing.cdlr + 5;
  ColumnCalendar calendar(timing);
  AllBursts all(timing);
  std::mt19937 random(9);
  Cycle now = 5000;
  for (int i = 0; i < 3000; ++i) {
    if (i % 16 == 0) calendar.advance(now += random() % 200);
    const Cycle from = now + random() % 400;
    const auto group = static_cast<unsigned>(random() % 4);
    if (random() % 6 == 0) {
      ASSERT_EQ(calendar.write(from, group), all.write(from, group)) << i;
    } else {
      ASSERT_EQ(calendar.read(from, group), all.read(from, group)) << i;
    }
  }
}

// 0: bank groups do not matter.
INSTANTIATE_TEST_SUITE_P(ClocksInAGroup, ColumnCalendarTest, ::testing::Values(0u, 4u, 7u), grtx::test::PrintedName{});

TEST(ArrivalsTest, EqualACycleForEachSector) {
  constexpr std::size_t kLines = 40, kSectors = 4;
  Arrivals arrivals(kLines, kSectors);
  std::vector<Cycle> comes(kLines * kSectors);
  std::mt19937_64 random(5);
  unsigned seen_late = 0;
  Cycle now = 0;
  for (int i = 0; i < 40000; ++i) {
    if (random() % 8 == 0) arrivals.advance(now += random() % (i % 100 == 0 ? Cycle{1} << 30 : Cycle{500}));
    const auto line = static_cast<std::size_t>(random() % kLines);
    const auto sectors = static_cast<std::uint8_t>(random() % 16);
    const auto sector = static_cast<unsigned>(random() % kSectors);
    switch (random() % 4) {
      case 0:
        arrivals.come(line, sector, comes[line * kSectors + sector] = now + random() % 2000);
        break;
      case 1:
        arrivals.are_there(line, sectors);
        for (unsigned s = 0; s < kSectors; ++s) {
          if ((sectors >> s & 1) != 0) comes[line * kSectors + s] = 0;
        }
        break;
      default:
        const Cycle asked = now + random() % 1000;
        unsigned late = 0;
        Cycle last = asked, expected = asked;
        for (unsigned s = 0; s < kSectors; ++s) {
          const Cycle at = comes[line * kSectors + s];
          if ((sectors >> s & 1) == 0 || at <= asked) continue;
          ++late;
          expected = std::max(expected, at);
        }
        ASSERT_EQ(arrivals.count_late(line, sectors, asked, last), late) << i;
        ASSERT_EQ(last, expected) << i;
        seen_late += late;
    }
  }
  EXPECT_GT(now, Cycle{1} << 33);
  EXPECT_GT(seen_late, 1000u);
}

}  // namespace
}  // namespace grtx::sim
