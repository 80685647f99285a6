// SPDX-License-Identifier: Apache-2.0
// L2 slice: hit latency, miss latency through the DRAM to the cycle, one access per cycle, `perfect`.
#include "grtx/base/error.h"
#include "grtx/modules/cache/l2_slice.h"
#include "modules/cache/l2_bench.h"

namespace grtx::modules {
namespace {

constexpr DramTiming kT{};

class L2Latency : public SystemCTest {};

TEST_F(L2Latency, AHitsReplyIsPushedExactlyAfterTheLatency) {
  for (const unsigned latency : {1u, 30u, 165u}) {
    fresh_context();
    L2Slice::Config config = L2Bench::one_slice();
    config.latency = latency;
    L2Bench bench(config);
    bench.client.read(10, 0x40);
    const auto hit = bench.client.read(2000, 0x40);
    EXPECT_TRUE(run_until_quiet(bench.core, 10000));
    EXPECT_EQ(bench.client.answered(hit), 2000 + latency + 1);  // 1: the link
    EXPECT_TRUE(bench.conserved());
  }
}

TEST_F(L2Latency, AMissAddsTheDram) {
  L2Bench bench;
  const auto closed = bench.client.read(10, 0);
  const auto open = bench.client.read(2000, 32);
  const auto conflict = bench.client.read(4000, 16 * 2048);
  EXPECT_TRUE(run_until_quiet(bench.core, 10000));
  EXPECT_EQ(bench.client.answered(closed), bench.miss_seen(10, kT.rcd + kT.cl + kT.ccd + 256));
  EXPECT_EQ(bench.client.answered(open), bench.miss_seen(2000, kT.cl + kT.ccd + 256));
  EXPECT_EQ(bench.client.answered(conflict), bench.miss_seen(4000, kT.rp + kT.rcd + kT.cl + kT.ccd + 256));
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L2Latency, OneAccessACycleAtFullLatency) {
  L2Bench bench;
  for (unsigned i = 0; i < 8; ++i) bench.client.read(10 + i, i * 32);
  std::vector<std::uint32_t> tags;
  for (unsigned i = 0; i < 500; ++i) tags.push_back(bench.client.read(2000 + i, i % 8 * 32));
  EXPECT_TRUE(run_until_quiet(bench.core, 10000));
  for (unsigned i = 0; i < 500; ++i) EXPECT_EQ(bench.client.answered(tags[i]), 2000 + i + 165 + 1);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L2Latency, PerfectAlwaysHits) {
  L2Slice::Config config = L2Bench::one_slice();
  config.perfect = true;
  L2Bench bench(config);
  const auto read = bench.client.read(10, 0x40);
  const auto write = bench.client.write(11, 0x80);
  EXPECT_TRUE(run_until_quiet(bench.core, 10000));
  EXPECT_EQ(bench.client.answered(read), 10u + 165 + 1);
  EXPECT_EQ(bench.client.answered(write), 11u + 165 + 1);
  EXPECT_EQ(bench.checker.transactions(), 0u);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L2Latency, ARefusedDramTransactionStopsTheRun) {
  L2Slice::Config config = L2Bench::one_slice();
  Dram::Config dram = L2Bench::dram_of(config);
  dram.bytes = 1 << 20;
  L2Bench bench(config, dram);
  bench.client.read(10, 1 << 20);
  try {
    run(bench.core, 5000);
    FAIL() << "an address beyond the memory went unnoticed";
  } catch (const sc_core::sc_report& report) {  // the kernel wraps what a process throws
    EXPECT_NE(std::string(report.what()).find("the memory answered a"), std::string::npos);
  }
}

TEST_F(L2Latency, ImpossibleConfigurationsAreRefused) {
  ClockDomain clock("clock", 1365.0);
  L2Slice::Config config;
  config.slice = 4;
  EXPECT_THROW(L2Slice("a", config, clock), Error);
  config = {};
  config.dram_queue = 2;
  EXPECT_THROW(L2Slice("b", config, clock), Error);
  config = {};
  config.interleave.slices = 3;
  config.interleave.xor_hash = true;
  EXPECT_THROW(L2Slice("c", config, clock), Error);
  config = {};
  config.interleave.bytes = config.geometry.line_bytes;
  EXPECT_NO_THROW(L2Slice("d", config, clock));
  config.geometry.line_bytes *= 2;
  EXPECT_THROW(L2Slice("e", config, clock), Error);
}

}  // namespace
}  // namespace grtx::modules
