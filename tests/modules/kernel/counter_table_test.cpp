// SPDX-License-Identifier: Apache-2.0
// Counters that are named once: how they add up, what statistics they become, and that no unit forgets one.
#include "grtx/modules/kernel/declare.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <set>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/dram/decide/dram_config.h"
#include "grtx/modules/noc/crossbar.h"
#include "grtx/modules/rt_unit/any_hit_collector/any_hit_collector.h"
#include "grtx/modules/rt_unit/checkpoint/checkpoint_unit.h"
#include "grtx/modules/rt_unit/intersection/intersection_unit.h"
#include "grtx/modules/rt_unit/memory_scheduler/memory_scheduler.h"
#include "grtx/modules/rt_unit/prefetcher/sibling_prefetcher.h"
#include "grtx/modules/rt_unit/rt_unit.h"
#include "grtx/modules/rt_unit/scheduler/rt_scheduler.h"
#include "grtx/modules/rt_unit/stack/stack_unit.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_buffer.h"
#include "grtx/modules/simt/decide/simt_core_config.h"

namespace grtx::modules {
namespace {

enum class Reason : std::uint8_t { a, b, c };
constexpr auto enum_names(Reason) { return names_in_order<Reason>({"a", "b", "c"}); }

struct Inner {
  std::uint64_t hits = 0;
  static const CounterTable<Inner>& table() {
    static const CounterTable<Inner> table = CounterTable<Inner>().exact(&Inner::hits, "hits", "1", "hits of a part");
    return table;
  }
};

struct Outer {
  std::uint64_t calls = 0;
  std::uint64_t hidden = 0;
  std::uint64_t longest = 0;
  std::array<std::uint64_t, 3> stalls{};
  std::array<std::uint64_t, 3> waits{};
  Distribution latency;
  Inner inner;
  static const CounterTable<Outer>& table() {
    using C = Outer;
    using Column = CounterColumn<decltype(&C::stalls)>;
    static const CounterTable<C> table =
        CounterTable<C>()
            .sum(&C::calls, "calls", "calls", "calls made")
            .sum(&C::hidden)
            .largest(&C::longest, "longest", "entries", "longest queue")
            .by_name<Reason>([](Reason reason) { return reason != Reason::b; },
                             Column{&C::stalls, "stall", "cycles", "by {}."},
                             Column{&C::waits, "wait", "cycles", "for {}"})
            .ratio({"calls", &C::calls}, {"", &C::hidden}, "share", "ratio", "calls / hidden")
            .distribution(&C::latency, "latency", "cycles", "mean", "longest")
            .part(&C::inner, ".inner");
    return table;
  }
};

Outer example(std::uint64_t n) {
  Outer c{n, 2 * n, n, {n, n + 1, n + 2}, {0, 0, n}, {}, {5 * n}};
  c.latency.add(n);
  return c;
}

TEST(CounterTable, AddsUpByTheRuleOfEachField) {
  Outer total = example(10);
  Outer::table().add(total, example(3));
  EXPECT_EQ(total.calls, 13U);
  EXPECT_EQ(total.hidden, 26U);
  EXPECT_EQ(total.longest, 10U);
  EXPECT_THAT(total.stalls, ::testing::ElementsAre(13, 15, 17));
  EXPECT_EQ(total.latency.count(), 2U);
  EXPECT_EQ(total.latency.sum(), 13U);
  EXPECT_EQ(total.inner.hits, 65U);
}

TEST(CounterTable, DescribesInTheOrderOfTheTable) {
  StatisticList list;
  Outer::table().describe(example(4), list, "unit");
  std::string text;
  for (const Statistic& s : list.items()) {
    text += s.name + "=" + std::visit([](auto v) { return std::to_string(static_cast<long>(v * 10)); }, s.value) +
            s.unit + ":" + s.description + "\n";
  }
  EXPECT_EQ(text,
            "unit.calls=40calls:calls made\n"
            "unit.longest=40entries:longest queue\n"
            "unit.stall.a=40cycles:by a.\n"
            "unit.wait.a=0cycles:for a\n"
            "unit.stall.c=60cycles:by c.\n"
            "unit.wait.c=40cycles:for c\n"
            "unit.share=5ratio:calls / hidden\n"
            "unit.latency=40cycles:mean\n"
            "unit.latency_max=40cycles:longest\n"
            "unit.inner.hits=200"
            "1:hits of a part\n");
}

TEST(CounterTable, GivesEachStatisticTheKindOfItsRow) {
  StatisticList list;
  Outer::table().describe(example(4), list, "unit");
  std::vector<std::string> kinds;
  for (const Statistic& s : list.items()) kinds.emplace_back(name_of(s.kind));
  EXPECT_THAT(kinds, ::testing::ElementsAre("count", "largest", "count", "count", "count", "count", "ratio", "mean",
                                            "largest", "exact"));
  const Quotient& share = list.items()[6].of;
  EXPECT_EQ(share.part, 4U);
  EXPECT_EQ(share.whole, 8U);
  EXPECT_EQ(share.part_name, "unit.calls");
  EXPECT_EQ(share.whole_name, "");
}

TEST(CounterTable, KnowsWhetherAFieldWasForgotten) {
  EXPECT_EQ(Outer::table().bytes(), sizeof(Outer));
  EXPECT_LT(CounterTable<Outer>().sum(&Outer::calls).bytes(), sizeof(Outer));
}

/// Statistics that are not zero and that no table would print.
template <typename Counters>
std::vector<std::string> left_out(const Counters& counters) {
  StatisticList all = StatisticList::of_reference(), shown;
  Counters::table().describe(counters, all, "unit");
  Counters::table().describe(counters, shown, "unit");
  std::set<std::string> names;
  for (const Statistic& s : shown.items()) names.insert(s.name);
  std::vector<std::string> out;
  for (const Statistic& s : all.items()) {
    const bool zero = std::visit([](auto value) { return !(value > 0); }, s.value);
    const bool stands_for_several = s.name.find('<') != std::string::npos;
    if (!zero && !stands_for_several && !names.contains(s.name)) out.push_back(s.name);
  }
  return out;
}

/// With all counters at 1, the least that can happen, nothing is left out as if a unit were not used.
template <typename Counters>
void expect_listed(const char* name) {
  static_assert(sizeof(Counters) % sizeof(std::uint64_t) == 0);
  const std::vector<std::uint64_t> ones(sizeof(Counters) / sizeof(std::uint64_t), 1);
  Counters counters{};
  std::size_t bytes = sizeof counters;
  if constexpr (requires { counters.own; }) {  // those of a user's units are no plain numbers; they come last
    bytes -= sizeof counters.own;
    ASSERT_EQ(static_cast<void*>(&counters.own), reinterpret_cast<char*>(&counters) + bytes) << name;
  } else {
    static_assert(std::is_trivially_copyable_v<Counters>);
  }
  std::memcpy(static_cast<void*>(&counters), ones.data(), bytes);
  EXPECT_THAT(left_out(counters), ::testing::IsEmpty()) << name;
}

template <typename Counters>
void expect_complete(const char* name) {
  EXPECT_EQ(Counters::table().bytes(), sizeof(Counters)) << name << " has a field that its table lacks";
  expect_listed<Counters>(name);
}

TEST(CounterTable, HoldsAndListsEveryCounterOfEachUnit) {
  expect_complete<WarpBuffer::Counters>("warp buffer");
  expect_complete<RtScheduler::Counters>("RT scheduler");
  expect_complete<MemoryScheduler::Counters>("memory scheduler");
  expect_complete<IntersectionUnit::Counters>("intersection unit");
  expect_complete<AnyHitCollector::Counters>("any-hit collector");
  expect_complete<CheckpointUnit::Counters>("checkpoint unit");
  expect_complete<SiblingPrefetcher::Counters>("sibling prefetcher");
  expect_complete<StackUnit::Counters>("stack unit");
  expect_complete<RtUnitCounters>("RT unit");
  expect_complete<SimtCounters>("SIMT core");
  expect_complete<L1Counters>("L1");
  expect_complete<L2Counters>("L2");
  expect_complete<DramChannelCounters>("DRAM channel");
  expect_complete<CrossbarCounters::Network>("crossbar");
}

}  // namespace
}  // namespace grtx::modules
