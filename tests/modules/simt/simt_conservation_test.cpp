// SPDX-License-Identifier: Apache-2.0
// The SIMT core answers and acknowledges everything, and its results depend neither on construction order nor on idle
// skip nor on small links. What it executes of a trace is a law of each run (conservation.cpp), to the number in
// tests/rtl_tlm/plain.
#include <gtest/gtest.h>

#include <sstream>

#include "modules/simt/simt_bench.h"
#include "traces/random_group.h"

namespace grtx::modules {
namespace {

/// Runs all groups, slot by slot, and prints everything that was seen with its cycle.
std::string run_all(const traces::testing::RandomTrace& trace, SimtBench::Options options, SimtCounters* counters) {
  FreshContext();
  options.header = trace.header;
  SimtBench bench(options);
  for (unsigned i = 0; i < trace.groups.size(); ++i) bench.start(i, trace.groups[i], 1 + 13 * i);
  bench.run(20'000'000);
  EXPECT_EQ(bench.ends.size(), trace.groups.size());
  EXPECT_TRUE(bench.core->idle());
  const SimtCounters c = bench.core->counters();
  EXPECT_EQ(bench.requests.size(), c.memory.sectors());
  EXPECT_EQ(bench.memory_response.pushed(), c.memory.sectors());
  EXPECT_EQ(bench.any_hits_done.size(), bench.batches.size());
  if (counters != nullptr) *counters = c;
  std::ostringstream log;
  for (const auto& [cycle, call] : bench.calls) log << cycle << " call " << call.slot << ' ' << call.lanes << '\n';
  for (const auto& [cycle, done] : bench.any_hits_done)
    log << cycle << " hit " << done.slot << ' ' << done.lanes << '\n';
  for (const auto& [cycle, end] : bench.ends) log << cycle << " end " << end.slot << '\n';
  for (const auto& [cycle, r] : bench.requests)
    log << cycle << ' ' << r.address << ' ' << r.tag << ' ' << r.write << '\n';
  StatisticList list;
  describe(c, list, "simt");
  for (const Statistic& s : list.items()) {
    EXPECT_FALSE(s.unit.empty() || s.description.empty()) << s.name;
    log << s.name << ' ' << std::get<std::uint64_t>(s.value) << '\n';
  }
  return log.str();
}

traces::testing::RandomTrace small_trace(unsigned seed, bool checkpoint, std::uint64_t capacity) {
  return traces::testing::random_trace({.seed = seed,
                                        .groups = 9,
                                        .warp_size = 32,
                                        .checkpoint = checkpoint,
                                        .capacity = capacity,
                                        .two_level = seed % 2 == 0});
}

class SimtConservation : public SystemCTest {};

TEST_F(SimtConservation, WarpActivitiesAddUpToTheTimeFromLaunchToEnd) {
  SimtBench bench({});
  const traces::RayGroup group =
      uniform_group(32, std::vector<RoundScript>(3, {{{traces::LeafOutcome::inserted}}, {seen(5, true)}, 0, 0}));
  bench.start(0, group, 10);
  bench.start(4, group, 30);
  bench.run();
  ASSERT_EQ(bench.ends.size(), 2u);
  std::uint64_t resident = 0;
  for (const auto& [cycle, end] : bench.ends) resident += cycle - 1 - (end.slot == 0 ? 10 : 30);
  EXPECT_EQ(bench.core->counters().resident_warp_cycles(), resident);
}

TEST_F(SimtConservation, ResultsDoNotDependOnConstructionOrderOrIdleSkip) {
  const auto trace = small_trace(7, true, 40);
  SimtBench::Options options;
  options.split_batches = true;
  const std::string reference = run_all(trace, options, nullptr);
  for (unsigned order = 1; order < 4; ++order) {
    options.order = order;
    EXPECT_EQ(run_all(trace, options, nullptr), reference) << "order " << order;
  }
  options.idle_skip = false;
  EXPECT_EQ(run_all(trace, options, nullptr), reference) << "without idle skip";
}

TEST_F(SimtConservation, LinksOfOneEntryDelayButLoseNothing) {
  const auto trace = small_trace(9, true, 1000);
  SimtBench::Options options;
  options.split_batches = true;
  SimtCounters roomy, narrow;
  run_all(trace, options, &roomy);
  options.out_capacity = 1;
  run_all(trace, options, &narrow);
  EXPECT_EQ(narrow.shader.any_hit_calls, roomy.shader.any_hit_calls);
  EXPECT_EQ(narrow.shader.entries_processed, roomy.shader.entries_processed);
  EXPECT_GT(narrow.resident_warp_cycles(), roomy.resident_warp_cycles());
}

}  // namespace
}  // namespace grtx::modules
