// SPDX-License-Identifier: Apache-2.0
// L1: MSHRs merge requests of one sector, and every limit stalls without losing anything.
#include "grtx/modules/cache/l1_cache.h"
#include "modules/cache/l1_bench.h"

namespace grtx::modules {
namespace {

class L1Mshr : public SystemCTest {
 protected:
  static std::uint64_t stalls(const L1Bench& bench, L1Stall reason) {
    return bench.l1.counters().stalls[static_cast<std::size_t>(reason)];
  }
};

TEST_F(L1Mshr, RequestsOfAPendingSectorMergeIntoOneFetch) {
  L1Bench bench;
  for (unsigned i = 0; i < 4; ++i) {
    bench.client(0).read(10 + i, 0x40, Region::blas);
    bench.client(1).read(30 + i, 0x40, Region::leaf);
  }
  EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
  EXPECT_EQ(bench.memory.arrivals().size(), 1u);
  const L1Counters counters = bench.l1.counters();
  EXPECT_EQ(counters.region[static_cast<std::size_t>(Region::blas)].misses, 1u);
  EXPECT_EQ(counters.region[static_cast<std::size_t>(Region::blas)].hits_on_miss, 3u);
  EXPECT_EQ(counters.region[static_cast<std::size_t>(Region::leaf)].hits_on_miss, 4u);
  EXPECT_EQ(counters.nodes().reads, 8u);
  EXPECT_EQ(counters.nodes().hits, 0u);
  // All eight are released by the fill; each client takes one per cycle.
  const Cycle first = 10 + l1_miss_latency(bench.l1.config(), L1Bench::kMemoryLatency);
  for (unsigned i = 0; i < 4; ++i) {
    EXPECT_EQ(bench.client(0).answers()[i].cycle, first + i);
    EXPECT_EQ(bench.client(1).answers()[i].cycle, first + i);
    EXPECT_EQ(bench.client(0).answers()[i].response.tag, i);
    EXPECT_EQ(bench.client(1).answers()[i].response.region, Region::leaf);
  }
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L1Mshr, AFullMergeListStallsUntilTheFill) {
  L1Cache::Config config;
  config.mshr_merges = 3;
  L1Bench bench(config);
  for (unsigned i = 0; i < 4; ++i) bench.client().read(10 + i, 0x40);
  EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
  // The fill is seen at `filled`; the fourth request, visible from 13, is looked up in that cycle and hits.
  const Cycle filled = 10 + l1_miss_latency(config, L1Bench::kMemoryLatency) - 1;
  EXPECT_EQ(stalls(bench, L1Stall::merges_full), filled - 13);
  EXPECT_EQ(bench.client().answered(3), filled + config.latency);
  EXPECT_EQ(bench.l1.counters().region[0].hits, 1u);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L1Mshr, AMissWaitsForAFreeEntryAndHitsBehindItWaitToo) {
  L1Cache::Config config;
  config.mshr_entries = 2;
  L1Bench bench(config);
  for (unsigned i = 0; i < 3; ++i) bench.client().read(10 + i, 0x1000 + i * 128);
  EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
  const Cycle miss = l1_miss_latency(config, L1Bench::kMemoryLatency);
  const Cycle filled = 10 + miss - 1;
  EXPECT_EQ(stalls(bench, L1Stall::mshr_full), filled - 12);
  EXPECT_EQ(bench.client().answered(2), filled + miss);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L1Mshr, OneClientsFullMshrsDoNotHoldUpAnotherClientsHits) {
  L1Cache::Config config;
  config.mshr_entries = 1;
  L1Bench bench(config);
  bench.client(1).read(10, 0x20);
  bench.client(0).read(500, 0x1000);
  bench.client(0).read(501, 0x2000);
  const auto hit = bench.client(1).read(520, 0x20);
  EXPECT_TRUE(run_until_quiet(bench.clock, 2000));
  EXPECT_EQ(bench.client(1).answered(hit), 540u);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L1Mshr, AFullMissQueueStalls) {
  L1Cache::Config config;
  config.miss_queue = 2;
  L1Bench bench(config);
  bench.memory.takes = [](Cycle now) { return now >= 200; };
  for (unsigned i = 0; i < 20; ++i) bench.client().read(10 + i, 0x1000 + i * 32);
  run(bench.clock, 199);
  // 8 in the link down, 2 in the miss queue; the eleventh is refused.
  EXPECT_EQ(bench.l1.counters().region[0].misses, 10u);
  EXPECT_GT(stalls(bench, L1Stall::miss_queue_full), 100u);
  EXPECT_TRUE(run_until_quiet(bench.clock, 2000));
  EXPECT_EQ(bench.memory.arrivals().size(), 20u);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L1Mshr, OccupancyIsTheSumOfTheMissLatencies) {
  L1Bench bench;
  for (unsigned i = 0; i < 10; ++i) bench.client().read(10 + 3 * i, 0x1000 + i * 32);
  EXPECT_TRUE(run_until_quiet(bench.clock, 2000));
  EXPECT_EQ(bench.l1.counters().mshr_cycles, bench.l1.counters().miss_latency.sum());
}

}  // namespace
}  // namespace grtx::modules
