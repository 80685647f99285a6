// SPDX-License-Identifier: Apache-2.0
// Each statistic has a kind, which alone says how those of two units become one: by it a reader comes to what the table
// of the unit gives.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/dram/decide/dram_config.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/noc/crossbar.h"
#include "grtx/modules/rt_unit/rt_unit.h"
#include "grtx/modules/simt/decide/simt_core_config.h"

namespace grtx::modules {
namespace {

/// Counters of one unit, each a random number; those of a user's units, which come last, have none.
template <typename Counters>
Counters random_counters(std::mt19937& random) {
  Counters counters{};
  std::size_t bytes = sizeof counters;
  if constexpr (requires { counters.own; }) bytes -= sizeof counters.own;
  std::vector<std::uint64_t> numbers(bytes / sizeof(std::uint64_t));
  for (std::uint64_t& number : numbers) number = 1 + random() % 1000;
  std::memcpy(static_cast<void*>(&counters), numbers.data(), bytes);
  if constexpr (requires { counters.cycles; }) counters.cycles = 500;  // of the run, for all units
  if constexpr (requires { counters.own; }) counters.own.add("own.tests", 1 + random() % 1000, "tests", "of a user");
  return counters;
}

template <typename Counters>
std::map<std::string, Statistic> by_name(const Counters& counters) {
  StatisticList list;
  Counters::table().describe(counters, list, "unit");
  std::map<std::string, Statistic> statistics;
  for (const Statistic& s : list.items()) statistics[s.name] = s;
  return statistics;
}

/// What a reader makes of two statistics who knows nothing but their kind.
double together(const Statistic& a, const Statistic& b) {
  switch (a.kind) {
    case StatisticKind::count:
    case StatisticKind::exact:
    case StatisticKind::histogram:
      return a.number() + b.number();
    case StatisticKind::largest:
    case StatisticKind::bound:
      return std::max(a.number(), b.number());
    case StatisticKind::smallest:
      return std::min(a.number(), b.number());
    case StatisticKind::mean:
    case StatisticKind::ratio:
    case StatisticKind::share:
      return ratio(a.of.part + b.of.part, a.of.whole + b.of.whole);
    case StatisticKind::state:
      break;
  }
  return -1.0;
}

template <typename Counters>
void expect_kinds_add_up(const char* unit) {
  std::mt19937 random(7);
  for (int turn = 0; turn < 5; ++turn) {
    const Counters one = random_counters<Counters>(random), two = random_counters<Counters>(random);
    Counters sum{};
    if constexpr (requires { sum.cycles; }) sum.cycles = one.cycles;
    Counters::table().add(sum, one);
    Counters::table().add(sum, two);
    const auto of_one = by_name(one), of_two = by_name(two), of_both = by_name(sum);
    EXPECT_GT(of_both.size(), 2U) << unit;
    for (const auto& [name, statistic] : of_both) {
      ASSERT_TRUE(of_one.contains(name) && of_two.contains(name)) << unit << ": " << name;
      EXPECT_EQ(statistic.number(), together(of_one.at(name), of_two.at(name)))
          << unit << ": " << name << " is of kind " << name_of(statistic.kind);
    }
  }
}

TEST(StatisticKind, SaysHowThoseOfTwoUnitsBecomeOne) {
  expect_kinds_add_up<RtUnitCounters>("RT unit");
  expect_kinds_add_up<SimtCounters>("SIMT core");
  expect_kinds_add_up<L1Counters>("L1");
  expect_kinds_add_up<L2Counters>("L2");
  expect_kinds_add_up<DramChannelCounters>("DRAM channel");
  expect_kinds_add_up<CrossbarCounters::Network>("crossbar");
}

/// Means and ratios whose two counts have names; the others may be made from none.
template <typename Counters>
void expect_named(std::set<std::string>& named) {
  std::mt19937 random(3);
  const auto statistics = by_name(random_counters<Counters>(random));
  for (const auto& [name, s] : statistics) {
    const bool quotient =
        s.kind == StatisticKind::mean || s.kind == StatisticKind::ratio || s.kind == StatisticKind::share;
    EXPECT_EQ(std::holds_alternative<double>(s.value), quotient) << name << ": a real number is a mean or a ratio";
    if (s.of.part_name.empty() || s.of.whole_name.empty()) continue;
    EXPECT_TRUE(quotient) << name;
    named.insert(name);
    ASSERT_TRUE(statistics.contains(s.of.part_name)) << name << " names " << s.of.part_name;
    ASSERT_TRUE(statistics.contains(s.of.whole_name)) << name << " names " << s.of.whole_name;
    EXPECT_EQ(s.number(), statistics.at(s.of.part_name).number() / statistics.at(s.of.whole_name).number()) << name;
  }
}

TEST(StatisticKind, AReaderRecomputesWhatNamesItsTwoCounts) {
  std::set<std::string> named;
  expect_named<RtUnitCounters>(named);
  expect_named<SimtCounters>(named);
  expect_named<L1Counters>(named);
  expect_named<L2Counters>(named);
  expect_named<DramChannelCounters>(named);
  for (const char* name : {"unit.simt_efficiency", "unit.walk.lanes_per_entry", "unit.any_hit.lanes_per_batch",
                           "unit.node.hit_rate", "unit.all.hit_rate", "unit.read_hit_rate"}) {
    EXPECT_TRUE(named.contains(name)) << name;
  }
}

}  // namespace
}  // namespace grtx::modules
