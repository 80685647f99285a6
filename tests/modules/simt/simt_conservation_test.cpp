// The SIMT core executes every round, any-hit call, eviction and processed entry of a trace exactly once, answers and
// acknowledges everything, and its results depend neither on construction order nor on idle skip nor on small links.
#include <gtest/gtest.h>

#include <sstream>

#include "modules/simt/simt_bench.h"
#include "traces/random_group.h"

namespace grtx::modules {
namespace {

struct Expected {
  std::uint64_t ray_rounds = 0, warp_rounds = 0, calls = 0, evictions = 0, moves = 0, processed = 0, blended = 0;
};

Expected expected_of(const traces::testing::RandomTrace& trace) {
  Expected e;
  for (const traces::RayGroup& group : trace.groups) {
    std::size_t rounds = 0;
    for (const traces::Ray& ray : group.rays) {
      rounds = std::max(rounds, ray.rounds.size());
      e.ray_rounds += ray.rounds.size();
      for (const traces::Round& round : ray.rounds) e.moves += round.preloaded;
      for (const traces::Processed& p : ray.processed) e.blended += p.blended;
      e.processed += ray.processed.size();
      for (const traces::Event& event : ray.events) {
        if (event.kind() != traces::EventKind::visit_leaf || !traces::calls_any_hit(event.outcome())) continue;
        ++e.calls;
        const bool falls =
            event.outcome() == traces::LeafOutcome::displaced || event.outcome() == traces::LeafOutcome::rejected;
        if (trace.header.checkpoint && falls) ++e.evictions;
      }
    }
    e.warp_rounds += rounds;
  }
  return e;
}

/// Runs all groups, slot by slot, and prints everything that was seen with its cycle.
std::string run_all(const traces::testing::RandomTrace& trace, SimtBench::Options options, SimtCounters* counters) {
  sc_core::sc_curr_simcontext = new sc_core::sc_simcontext;
  sc_core::sc_default_global_context = sc_core::sc_curr_simcontext;
  set_time_resolution_to_fs();
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
  traces::testing::RandomOptions options;
  options.seed = seed;
  options.groups = 9;
  options.warp_size = 32;
  options.checkpoint = checkpoint;
  options.capacity = capacity;
  options.two_level = seed % 2 == 0;
  return traces::testing::random_trace(options);
}

class SimtConservation : public SystemCTest {};

TEST_F(SimtConservation, SingleRoundTracingSortsBeforeItBlends) {
  for (const unsigned k : {4U, 64U}) {  // the small buffer runs full
    traces::testing::RandomOptions random;
    random.seed = 11;
    random.groups = 9;
    random.warp_size = 32;
    random.checkpoint = false;
    random.k = k;
    random.tracing = traces::Tracing::single;
    const auto trace = traces::testing::random_trace(random);
    const Expected e = expected_of(trace);
    std::uint64_t passes = 0;  // of the longest lane of each warp's rounds
    for (const traces::RayGroup& group : trace.groups) {
      std::vector<unsigned> most;
      for (const traces::Ray& ray : group.rays) {
        most.resize(std::max(most.size(), ray.rounds.size()));
        for (std::size_t r = 0; r < ray.rounds.size(); ++r)
          most[r] = std::max<unsigned>(most[r], ray.rounds[r].k_count);
      }
      for (const unsigned entries : most) {
        for (unsigned run = 1; run < entries; run *= 2) ++passes;
      }
    }
    ASSERT_GT(passes, 0u);
    SimtCounters counters;
    const std::string log = run_all(trace, {}, &counters);
    EXPECT_EQ(counters.phases[static_cast<std::size_t>(PhaseKind::sort)], passes);
    EXPECT_EQ(counters.phases[static_cast<std::size_t>(PhaseKind::blend)], e.warp_rounds);
    EXPECT_EQ(counters.shader.any_hit_calls, e.calls);
    EXPECT_EQ(counters.shader.entries_processed, e.processed);
    EXPECT_EQ(counters.shader.k_buffer_mismatches, 0u);
    SimtBench::Options options;
    options.order = 2;
    options.idle_skip = false;
    EXPECT_EQ(run_all(trace, options, nullptr), log);
  }
}

TEST_F(SimtConservation, ClosestHitTracingCallsNoAnyHitShader) {
  traces::testing::RandomOptions random;
  random.seed = 12;
  random.groups = 9;
  random.warp_size = 32;
  random.checkpoint = false;
  random.k = 1;
  random.tracing = traces::Tracing::closest;
  const auto trace = traces::testing::random_trace(random);
  const Expected e = expected_of(trace);
  ASSERT_EQ(e.calls, 0u);
  ASSERT_GT(e.processed, 0u);
  SimtCounters counters;
  run_all(trace, {}, &counters);
  EXPECT_EQ(counters.shader.any_hit_batches, 0u);
  EXPECT_EQ(counters.shader.warp_rounds, e.warp_rounds);
  EXPECT_EQ(counters.shader.entries_processed, e.processed);
  EXPECT_EQ(counters.shader.k_buffer_mismatches, 0u);
  EXPECT_EQ(counters.memory.loads[static_cast<std::size_t>(Region::k_buffer)], 0u);
  EXPECT_EQ(counters.memory.stores[static_cast<std::size_t>(Region::k_buffer)], 0u);
}

TEST_F(SimtConservation, EverythingInTheTraceHappensOnce) {
  const struct {
    unsigned seed;
    bool checkpoint;
    std::uint64_t capacity;
    bool split;
  } cases[] = {
      {1, false, 0, false}, {2, false, 0, true}, {3, true, 1000, false}, {4, true, 1000, true}, {5, true, 12, false}};
  for (const auto& c : cases) {
    const auto trace = small_trace(c.seed, c.checkpoint, c.capacity);
    const Expected e = expected_of(trace);
    ASSERT_GT(e.calls, 0u);
    SimtBench::Options options;
    options.split_batches = c.split;
    SimtCounters counters;
    run_all(trace, options, &counters);
    EXPECT_EQ(counters.warps, trace.groups.size());
    EXPECT_EQ(counters.shader.ray_rounds, e.ray_rounds);
    EXPECT_EQ(counters.shader.warp_rounds, e.warp_rounds);
    EXPECT_EQ(counters.shader.any_hit_calls, e.calls);
    EXPECT_EQ(counters.shader.evictions, e.evictions);
    EXPECT_EQ(counters.shader.eviction_moves, e.moves);
    EXPECT_EQ(counters.shader.entries_processed, e.processed);
    EXPECT_EQ(counters.shader.entries_blended, e.blended);
    EXPECT_EQ(counters.shader.k_buffer_mismatches, 0u);
    EXPECT_EQ(counters.all_instructions(), counters.issue_busy_cycles);
    EXPECT_EQ(counters.phases[static_cast<std::size_t>(PhaseKind::prologue)], trace.groups.size());
    EXPECT_EQ(counters.phases[static_cast<std::size_t>(PhaseKind::evict_move)], c.checkpoint ? e.warp_rounds : 0u);
    EXPECT_EQ(counters.phases[static_cast<std::size_t>(PhaseKind::blend)], e.warp_rounds);
  }
}

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
  const Expected e = expected_of(trace);
  SimtBench::Options options;
  options.out_capacity = 1;
  options.split_batches = true;
  SimtCounters counters;
  run_all(trace, options, &counters);
  EXPECT_EQ(counters.shader.any_hit_calls, e.calls);
  EXPECT_EQ(counters.shader.entries_processed, e.processed);
}

}  // namespace
}  // namespace grtx::modules
