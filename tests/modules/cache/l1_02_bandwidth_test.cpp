// SPDX-License-Identifier: Apache-2.0
// L1: one request per client and one per bank a cycle; conflicts cost a cycle each; responses leave one per client a
// cycle.
#include <gmock/gmock.h>

#include <algorithm>

#include "grtx/modules/cache/l1_cache.h"
#include "modules/cache/l1_bench.h"

namespace grtx::modules {
namespace {

using ::testing::Each;

class L1Bandwidth : public SystemCTest {
 protected:
  static std::uint64_t stalls(const L1Bench& bench, L1Stall reason) {
    return bench.l1.counters().stalls[static_cast<std::size_t>(reason)];
  }
  /// Brings sectors [0, count) in, one after the other.
  static void warm(L1Bench& bench, unsigned count) {
    for (unsigned i = 0; i < count; ++i) bench.client().read(10 + i, i * kSectorBytes);
  }
};

TEST_F(L1Bandwidth, AClientReadsASectorEveryCycle) {
  L1Bench bench;
  warm(bench, 16);
  std::vector<std::uint32_t> tags;
  for (unsigned i = 0; i < 64; ++i) tags.push_back(bench.client().read(1000 + i, i % 16 * kSectorBytes));
  EXPECT_TRUE(run_until_quiet(bench.clock, 3000));
  for (unsigned i = 0; i < 64; ++i) EXPECT_EQ(bench.client().answered(tags[i]), 1000 + i + 20);
  EXPECT_THAT(bench.l1.counters().stalls, Each(0u));
}

TEST_F(L1Bandwidth, ClientsOnDifferentBanksDoNotDisturbEachOther) {
  L1Cache::Config config;
  config.clients = 4;
  L1Bench bench(config);
  warm(bench, 4);
  for (unsigned cycle = 0; cycle < 32; ++cycle) {
    for (unsigned c = 0; c < 4; ++c) bench.client(c).read(1000 + cycle, (cycle + c) % 4 * kSectorBytes);
  }
  EXPECT_TRUE(run_until_quiet(bench.clock, 3000));
  for (unsigned c = 0; c < 4; ++c) EXPECT_EQ(bench.client(c).answers().back().cycle, 1000u + 31 + 20);
  EXPECT_THAT(bench.l1.counters().stalls, Each(0u));
}

// More than fit into a word: 16 RT units with four ports each, and the SIMT core, are 65.
TEST_F(L1Bandwidth, SeventyClientsTakeTurns) {
  L1Cache::Config config;
  config.clients = 70;
  config.banks = 1;
  L1Bench bench(config);
  warm(bench, 1);
  for (unsigned c = 0; c < config.clients; ++c) {
    for (unsigned turn = 0; turn < 2; ++turn) bench.client(c).read(1000, 0);
  }
  EXPECT_TRUE(run_until_quiet(bench.clock, 3000));
  std::vector<Cycle> answers;
  for (unsigned c = 0; c < config.clients; ++c) {
    ASSERT_GE(bench.client(c).answers().size(), 2U) << "client " << c;
    answers.push_back(bench.client(c).answers().back().cycle);
  }
  std::sort(answers.begin(), answers.end());
  EXPECT_EQ(std::unique(answers.begin(), answers.end()), answers.end()) << "the only bank serves one per cycle";
  EXPECT_EQ(answers.back(), 1000U + 2 * config.clients - 1 + 20);
}

TEST_F(L1Bandwidth, ABankServesOneClientACycle) {
  struct Case {
    unsigned banks;
    std::uint64_t stride;  // between the sectors of the four clients
    Cycle last;            // answer of the last of four requests sent at once, relative to a hit without conflict
    std::uint64_t stalled;
  };
  // n requests for one bank take n cycles, and the k-th waits k cycles: 0 + 1 + 2 + 3 for four.
  const Case cases[] = {{4, 32, 0, 0}, {4, 64, 1, 2}, {4, 128, 3, 6}, {2, 32, 1, 2}, {1, 32, 3, 6}, {8, 64, 0, 0}};
  for (const Case& c : cases) {
    fresh_context();
    L1Cache::Config config;
    config.clients = 4;
    config.banks = c.banks;
    L1Bench bench(config);
    for (unsigned i = 0; i < 4; ++i) bench.client().read(10 + i, i * c.stride);
    Cycle last = 0;
    for (unsigned i = 0; i < 4; ++i) bench.client(i).read(1000, i * c.stride);
    EXPECT_TRUE(run_until_quiet(bench.clock, 3000));
    for (unsigned i = 0; i < 4; ++i) last = std::max(last, bench.client(i).answers().back().cycle);
    EXPECT_EQ(last, 1020 + c.last) << c.banks << " banks, stride " << c.stride;
    EXPECT_EQ(stalls(bench, L1Stall::bank_conflict), c.stalled) << c.banks << " banks, stride " << c.stride;
  }
}

TEST_F(L1Bandwidth, RotatingPriorityIsFairAndFixedPriorityIsNot) {
  for (const bool rotating : {true, false}) {
    fresh_context();
    L1Cache::Config config;
    config.rotating_priority = rotating;
    L1Bench bench(config);
    warm(bench, 1);
    for (unsigned i = 0; i < 40; ++i) {  // both clients want bank 0 in every cycle
      bench.client(0).read(1000, 0);
      bench.client(1).read(1000, 0);
    }
    EXPECT_TRUE(run_until_quiet(bench.clock, 3000));
    const Cycle end0 = bench.client(0).answers().back().cycle;
    const Cycle end1 = bench.client(1).answers().back().cycle;
    EXPECT_EQ(std::max(end0, end1), 1000u + 79 + 20);
    EXPECT_EQ(std::min(end0, end1), rotating ? 1000u + 78 + 20 : 1000u + 39 + 20);
  }
}

TEST_F(L1Bandwidth, ABlockedResponsePortBacksUpIntoTheRequests) {
  L1Bench bench;
  warm(bench, 1);
  bench.client().takes = [](Cycle now) { return now < 900 || now >= 1200; };
  for (unsigned i = 0; i < 100; ++i) bench.client().read(1000 + i, 0);
  run(bench.clock, 1199);
  // 8 in the response link, 20 in the hit pipeline, 8 in the request link.
  EXPECT_EQ(bench.l1.counters().region[0].hits, 28u);
  EXPECT_GT(stalls(bench, L1Stall::response_port), 0u);
  EXPECT_FALSE(bench.l1.idle());
  EXPECT_TRUE(run_until_quiet(bench.clock, 3000));
  EXPECT_TRUE(bench.conserved());
  EXPECT_EQ(bench.client().answers().back().cycle, 1200u + 99);  // one a cycle from the release on
}

TEST_F(L1Bandwidth, TheFillPortTakesOneSectorACycle) {
  L1Bench bench;
  for (unsigned i = 0; i < 2; ++i) {
    for (unsigned c = 0; c < 2; ++c) bench.client(c).read(10 + i, (2 * i + c) * kSectorBytes);
  }
  EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
  const Cycle first = 10 + l1_miss_latency(bench.l1.config(), L1Bench::kMemoryLatency);
  EXPECT_EQ(bench.client(0).answers()[0].cycle, first);
  EXPECT_EQ(bench.client(1).answers()[0].cycle, first + 1);  // misses also leave one per cycle
  // The second pair: client 1 had priority, because client 0 won first before.
  EXPECT_EQ(bench.client(1).answers()[1].cycle, first + 2);
  EXPECT_EQ(bench.client(0).answers()[1].cycle, first + 3);
}

}  // namespace
}  // namespace grtx::modules
