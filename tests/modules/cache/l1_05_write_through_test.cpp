// SPDX-License-Identifier: Apache-2.0
// L1: writes go through to the L2, never allocate, keep a present sector valid, and are answered when the L2 has
// answered.
#include "grtx/modules/cache/l1_cache.h"
#include "modules/cache/l1_bench.h"

namespace grtx::modules {
namespace {

class L1WriteThrough : public SystemCTest {};

TEST_F(L1WriteThrough, AWriteIsAnsweredWhenTheMemoryHasAcknowledgedIt) {
  L1Bench bench;
  const auto write = bench.client().write(10, 0x80);
  EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
  ASSERT_EQ(bench.memory.arrivals().size(), 1u);
  EXPECT_TRUE(bench.memory.arrivals()[0].request.write);
  EXPECT_EQ(bench.client().answered(write), 10 + l1_miss_latency(bench.l1.config(), L1Bench::kMemoryLatency));
  EXPECT_TRUE(bench.client().answers()[0].response.write);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L1WriteThrough, AWriteMissDoesNotAllocateAndAWriteHitKeepsTheSector) {
  L1Bench bench;
  bench.client().write(10, 0x80);
  bench.client().read(500, 0x80);  // misses
  bench.client().write(1000, 0x80);
  const auto hit = bench.client().read(1010, 0x80);  // while the write is still on its way
  EXPECT_TRUE(run_until_quiet(bench.clock, 3000));
  EXPECT_EQ(bench.client().answered(hit), 1030u);
  const L1Counters counters = bench.l1.counters();
  const auto k_buffer = counters.region[static_cast<std::size_t>(Region::k_buffer)];
  EXPECT_EQ(k_buffer.writes, 2u);
  EXPECT_EQ(k_buffer.write_hits, 1u);
  EXPECT_EQ(counters.sent_writes, 2u);
  EXPECT_EQ(counters.sent_reads, 1u);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L1WriteThrough, AnswersGoToTheClientThatWrote) {
  L1Cache::Config config;
  config.clients = 3;
  config.sm = 5;
  L1Bench bench(config);
  bench.client(0).write(10, 0x00);
  bench.client(2).write(10, 0x20);
  bench.client(1).read(10, 0x40);
  EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
  for (unsigned c = 0; c < 3; ++c) EXPECT_EQ(bench.client(c).answers().size(), 1u);
  for (const auto& arrival : bench.memory.arrivals()) EXPECT_EQ(arrival.request.sm, 5);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L1WriteThrough, WritesTouchTheLineForReplacement) {
  L1Cache::Config config;
  config.geometry = {256, 128, 32, 2};
  L1Bench bench(config);
  bench.client().read(10, 0);
  bench.client().read(300, 128);
  bench.client().write(600, 0);   // line 0 is now the newer one
  bench.client().read(900, 256);  // evicts line 128
  const auto stays = bench.client().read(1200, 0);
  EXPECT_TRUE(run_until_quiet(bench.clock, 3000));
  EXPECT_EQ(bench.client().answered(stays), 1220u);
}

}  // namespace
}  // namespace grtx::modules
