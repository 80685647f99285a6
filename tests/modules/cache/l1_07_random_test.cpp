// SPDX-License-Identifier: Apache-2.0
// L1: random traffic with random back-pressure loses nothing, ends empty, keeps every conservation law, and does not
// depend on idle skip.
#include <map>
#include <set>

#include "grtx/modules/cache/l1_cache.h"
#include "modules/cache/l1_bench.h"

namespace grtx::modules {
namespace {

class L1Random : public SystemCTest {
 protected:
  struct Result {
    std::vector<std::pair<std::string, std::variant<std::uint64_t, double>>> statistics;
    std::vector<Cycle> answers;
    L1Counters counters;
  };
  static Result simulate(std::uint64_t seed, bool idle_skip) {
    fresh_context();
    Random random(seed);
    L1Cache::Config config;
    config.clients = 3;
    config.geometry = {4096, 128, 32, seed % 3 == 1 ? 1u : 8u};
    config.mshr_entries = seed % 2 == 0 ? 6u : 64u;
    config.mshr_merges = 3;
    config.miss_queue = seed % 4 == 1 ? 3u : 5u;
    if (seed % 4 != 1) config.private_writes.policy = WritePolicy::write_back;
    config.write_back_buffer = static_cast<unsigned>(1 + seed % 2);
    config.private_writes.allocate = seed % 3 != 0;
    config.widths = {1, static_cast<unsigned>(1 + seed % 4), 2};
    L1Bench bench(config, 60, idle_skip);
    std::set<std::uint64_t> written_sectors;
    const auto sometimes = [seed](unsigned salt, unsigned percent) {
      return [=](Cycle now) { return Random(seed * 977 + now * 13 + salt).chance(percent); };
    };
    bench.memory.takes = sometimes(1, seed % 2 == 0 ? 70 : 25);
    bench.memory.answers = sometimes(2, 70);
    for (unsigned c = 0; c < 3; ++c) {
      bench.client(c).takes = sometimes(3 + c, seed % 3 == 0 ? 20 : 70);
      Cycle cycle = 10;
      for (unsigned i = 0; i < 700; ++i) {
        cycle += random.below(4) == 0 ? random.below(20) : 1;
        MemoryRequest r{.address = random.below(seed % 3 == 0 ? 100 : 256) * kSectorBytes,
                        .region = static_cast<Region>(random.below(kRegionCount)),
                        .write = random.chance(20)};
        r.prefetch = !r.write && random.chance(20);
        if (r.write) written_sectors.insert(r.address);
        bench.client(c).at(cycle, r);
      }
    }
    run(bench.clock, 60000);
    EXPECT_TRUE(bench.conserved()) << "seed " << seed;

    const L1Counters counters = bench.l1.counters();
    const auto all = counters.all();
    EXPECT_EQ(all.reads, all.hits + all.hits_on_miss + all.misses);
    EXPECT_EQ(counters.prefetches, counters.prefetches_redundant + counters.prefetches_fetched);
    EXPECT_EQ(counters.prefetches_fetched,
              counters.prefetches_useful + counters.prefetches_late + counters.prefetches_unused);
    EXPECT_EQ(counters.sent_reads, all.misses + counters.prefetches_fetched);
    EXPECT_EQ(counters.fills, counters.sent_reads);
    EXPECT_EQ(counters.sent_writes - counters.write_backs, all.writes - counters.kept_writes);
    EXPECT_EQ(counters.kept_writes, counters.rewrites + counters.write_backs + bench.l1.dirty_sectors());
    // Nothing that was written is lost: it has reached the memory since, or is dirty.
    std::map<std::uint64_t, bool> at_memory;
    for (const auto& written : written_sectors) at_memory[written] = false;
    for (const auto& arrival : bench.memory.arrivals()) {
      if (arrival.request.write) at_memory.at(arrival.request.address) = true;
    }
    const auto missing = std::count_if(at_memory.begin(), at_memory.end(), [](const auto& s) { return !s.second; });
    EXPECT_LE(static_cast<std::uint64_t>(missing), bench.l1.dirty_sectors());
    EXPECT_EQ(counters.sent_reads + counters.sent_writes, bench.memory.arrivals().size());

    Result result;
    result.counters = counters;
    StatisticList list;
    bench.l1.statistics(list, "l1");
    for (const Statistic& s : list.items()) result.statistics.emplace_back(s.name, s.value);
    for (unsigned c = 0; c < 3; ++c) {
      for (const auto& a : bench.client(c).answers()) {
        result.answers.push_back(a.cycle);
        result.answers.push_back(a.response.tag);
      }
    }
    return result;
  }
};

TEST_F(L1Random, NothingIsLostAndIdleSkipChangesNothing) {
  L1Counters sum;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const Result skipping = simulate(seed, true);
    const Result ticking = simulate(seed, false);
    EXPECT_EQ(skipping.statistics, ticking.statistics);
    EXPECT_EQ(skipping.answers, ticking.answers);
    sum += skipping.counters;
  }
  EXPECT_GT(sum.fills_bypassed, 0u);
  EXPECT_GT(sum.write_backs, 0u);
  for (std::size_t i = 0; i < sum.stalls.size(); ++i)
    EXPECT_GT(sum.stalls[i], 0u) << name_at<L1Stall>(i) << " untested";
}

}  // namespace
}  // namespace grtx::modules
