// SPDX-License-Identifier: Apache-2.0
// L2 slice: merging, limits, and random traffic against every limit with conservation and idle skip on and off.
#include "grtx/modules/cache/l2_slice.h"
#include "modules/cache/l2_bench.h"

namespace grtx::modules {
namespace {

class L2Mshr : public SystemCTest {
 protected:
  static std::uint64_t stalls(const L2Bench& bench, L2Stall reason) {
    return bench.l2.counters().stalls[static_cast<std::size_t>(reason)];
  }
};

TEST_F(L2Mshr, ReadsOfAPendingSectorMerge) {
  L2Bench bench;
  for (unsigned i = 0; i < 4; ++i) bench.client.read(10 + i, 0x40);
  EXPECT_TRUE(run_until_quiet(bench.core, 10000));
  EXPECT_EQ(bench.l2.counters().dram_reads, 1u);
  EXPECT_EQ(bench.l2.counters().all().hits_on_miss, 3u);
  const Cycle first = bench.miss_seen(10, DramTiming{}.rcd + DramTiming{}.cl + DramTiming{}.ccd + 256);
  for (unsigned i = 0; i < 4; ++i) EXPECT_EQ(bench.client.answered(i), first + i) << "one reply per cycle";
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L2Mshr, TheFifthReadWaitsForTheFill) {
  L2Bench bench;
  for (unsigned i = 0; i < 5; ++i) bench.client.read(10 + i, 0x40);
  EXPECT_TRUE(run_until_quiet(bench.core, 10000));
  EXPECT_EQ(bench.l2.counters().all().hits, 1u);
  const Cycle filled = bench.client.answered(0) - 1;
  EXPECT_EQ(stalls(bench, L2Stall::merges_full), filled - (10 + 4 + 165));
  EXPECT_EQ(bench.client.answered(4), filled + 1 + 4);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L2Mshr, MissesBeyondTheEntriesWait) {
  L2Slice::Config config = L2Bench::one_slice();
  config.mshr_entries = 2;
  L2Bench bench(config);
  for (unsigned i = 0; i < 5; ++i) bench.client.read(10 + i, i * 128);
  EXPECT_TRUE(run_until_quiet(bench.core, 10000));
  EXPECT_GT(stalls(bench, L2Stall::mshr_full), 0u);
  EXPECT_EQ(bench.l2.counters().dram_reads, 5u);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L2Mshr, RandomTrafficAgainstEveryLimit) {
  using Trace = std::vector<std::pair<Cycle, std::uint64_t>>;
  std::array<std::uint64_t, kCountOf<L2Stall>> reached{};
  const auto simulate = [&](std::uint64_t seed, bool idle_skip) {
    fresh_context();
    L2Slice::Config config = L2Bench::one_slice();
    config.latency = 20;
    config.queue = 4;
    config.geometry = {4096, 128, 32, 4};
    config.mshr_entries = seed % 2 == 0 ? 8 : 64;
    config.mshr_merges = 3;
    config.reply_queue = seed % 3 == 0 ? 3 : 8;
    config.dram_queue = 5;
    Dram::Config dram = L2Bench::dram_of(config);
    dram.channel.queue = 8;
    L2Bench bench(config, dram, idle_skip);
    bench.client.takes = [seed](Cycle now) { return Random(seed * 31 + now).chance(seed % 3 == 0 ? 20 : 80); };
    Random random(seed);
    Cycle cycle = 10;
    for (unsigned i = 0; i < 2000; ++i) {
      cycle += random.chance(80) ? 1 : random.below(30);
      MemoryRequest r{.address = random.below(seed % 3 == 0 ? 192 : 1024) * kSectorBytes,
                      .region = static_cast<Region>(random.below(kRegionCount)),
                      .write = random.chance(40)};
      bench.client.at(cycle, r);
    }
    run(bench.core, 60000);
    EXPECT_TRUE(bench.conserved()) << "seed " << seed;
    const auto all = bench.l2.counters().all();
    EXPECT_EQ(all.reads, all.hits + all.hits_on_miss + all.misses);
    EXPECT_EQ(bench.l2.counters().mshr_cycles, bench.l2.counters().miss_latency.sum());
    Trace trace;
    for (const auto& a : bench.client.answers()) trace.emplace_back(a.cycle, a.response.tag);
    StatisticList list;
    bench.l2.statistics(list, "l2");
    for (const Statistic& s : list.items()) {
      if (const auto* count = std::get_if<std::uint64_t>(&s.value)) trace.emplace_back(0, *count);
    }
    for (std::size_t i = 0; i < reached.size(); ++i) reached[i] += bench.l2.counters().stalls[i];
    return trace;
  };
  for (std::uint64_t seed = 1; seed <= 6; ++seed) EXPECT_EQ(simulate(seed, true), simulate(seed, false));
  for (std::size_t i = 0; i < reached.size(); ++i) EXPECT_GT(reached[i], 0u) << name_at<L2Stall>(i) << " untested";
}

}  // namespace
}  // namespace grtx::modules
