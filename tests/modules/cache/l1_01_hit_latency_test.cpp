// SPDX-License-Identifier: Apache-2.0
// L1: a request visible at cycle c is answered at exactly c + latency when it hits.
#include "grtx/base/error.h"
#include "grtx/modules/cache/l1_cache.h"
#include "modules/cache/l1_bench.h"

namespace grtx::modules {
namespace {

class L1HitLatency : public SystemCTest {};

TEST_F(L1HitLatency, AHitTakesExactlyTheConfiguredCycles) {
  for (const unsigned latency : {1u, 2u, 20u, 33u}) {
    fresh_context();
    L1Cache::Config config;
    config.latency = latency;
    L1Bench bench(config);
    bench.client().read(10, 0x1000);
    const auto hit = bench.client().read(500, 0x1000);
    run(bench.clock, 500 + latency);  // executes the cycles below this one
    EXPECT_EQ(bench.client().answered(hit), kNever) << "before its time";
    run(bench.clock, 1);
    EXPECT_EQ(bench.client().answered(hit), 500 + latency);
    EXPECT_TRUE(bench.conserved());
  }
}

TEST_F(L1HitLatency, AMissTakesTheTagTheLinksAndTheMemory) {
  L1Cache::Config config;
  config.tag_latency = 3;
  L1Bench bench(config);
  const auto miss = bench.client().read(10, 0x1000);
  EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
  ASSERT_EQ(bench.memory.arrivals().size(), 1u);
  EXPECT_EQ(bench.memory.arrivals()[0].cycle, 10 + 3 + 1);
  EXPECT_EQ(bench.client().answered(miss), 10 + l1_miss_latency(config, L1Bench::kMemoryLatency));
  EXPECT_EQ(bench.l1.counters().miss_latency.max(), 3 + 1 + L1Bench::kMemoryLatency);
}

TEST_F(L1HitLatency, OtherSectorsOfAPresentLineMiss) {
  L1Bench bench;
  bench.client().read(10, 0x1000);
  bench.client().read(500, 0x1020);
  bench.client().read(1000, 0x1020);
  EXPECT_TRUE(run_until_quiet(bench.clock, 2000));
  const auto tlas = bench.l1.counters().region[0];
  EXPECT_EQ(tlas.reads, 3u);
  EXPECT_EQ(tlas.misses, 2u);
  EXPECT_EQ(tlas.hits, 1u);
}

TEST_F(L1HitLatency, APerfectCacheAlwaysHitsAndAsksNobody) {
  L1Cache::Config config;
  config.perfect = true;
  L1Bench bench(config);
  const auto read = bench.client().read(10, 0x1000);
  const auto write = bench.client().write(11, 0x2000);
  EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
  EXPECT_EQ(bench.client().answered(read), 30u);
  EXPECT_EQ(bench.client().answered(write), 31u);
  EXPECT_TRUE(bench.memory.arrivals().empty());
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L1HitLatency, AnImpossibleConfigurationIsRefused) {
  ClockDomain clock("clock", 1365.0);
  L1Cache::Config config;
  config.geometry.ways = 100000;
  EXPECT_THROW(L1Cache("a", config, clock), Error);
  config = {};
  config.banks = 0;
  EXPECT_THROW(L1Cache("b", config, clock), Error);
}

}  // namespace
}  // namespace grtx::modules
