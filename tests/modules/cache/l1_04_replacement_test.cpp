// SPDX-License-Identifier: Apache-2.0
// L1: LRU within a set, independent sets, sectors of a line leave together.
#include "grtx/modules/cache/l1_cache.h"
#include "modules/cache/l1_bench.h"

namespace grtx::modules {
namespace {

class L1Replacement : public SystemCTest {
 protected:
  static L1Cache::Config small(unsigned sets, unsigned ways) {
    L1Cache::Config config;
    config.geometry = {std::uint64_t{sets} * ways * 128, 128, 32, ways};
    return config;
  }
  /// Reads the addresses one at a time, far apart, and tells which missed.
  static std::vector<bool> misses(L1Cache::Config config, const std::vector<std::uint64_t>& addresses) {
    fresh_context();
    L1Bench bench(config);
    for (std::size_t i = 0; i < addresses.size(); ++i) bench.client().read(10 + 300 * i, addresses[i]);
    EXPECT_TRUE(run_until_quiet(bench.clock, 300 * addresses.size() + 1000));
    std::vector<bool> missed;
    for (std::size_t i = 0; i < addresses.size(); ++i) {
      missed.push_back(bench.client().answered(static_cast<std::uint32_t>(i)) != 10 + 300 * i + config.latency);
    }
    return missed;
  }
};

TEST_F(L1Replacement, TheLeastRecentlyUsedLineGoes) {
  const std::uint64_t a = 0, b = 128, c = 256;
  using V = std::vector<bool>;
  EXPECT_EQ(misses(small(1, 2), {a, b, a, c, a, b}), (V{true, true, false, true, false, true}));
  EXPECT_EQ(misses(small(1, 2), {a, b, c, a, b, c}), (V{true, true, true, true, true, true}));
  EXPECT_EQ(misses(small(1, 3), {a, b, c, a, b, c}), (V{true, true, true, false, false, false}));
  EXPECT_EQ(misses(small(1, 1), {a, a, b, a}), (V{true, false, true, true}));
}

TEST_F(L1Replacement, EvictionTakesAllSectorsOfTheLine) {
  EXPECT_EQ(misses(small(1, 1), {0, 32, 0, 128, 32}), (std::vector<bool>{true, true, false, true, true}));
}

TEST_F(L1Replacement, SetsAreIndependent) {
  // Two sets: lines 0, 2, 4 map to set 0 and evict each other; line 1 stays.
  EXPECT_EQ(misses(small(2, 1), {128, 0, 256, 512, 128}), (std::vector<bool>{true, true, true, true, false}));
}

TEST_F(L1Replacement, ThePapersCacheHoldsExactlyItsCapacity) {
  // One access at a time. 1024 lines of 128 B in 4 sets of 256 ways: a second pass over 1024 lines hits, over 1025
  // lines the LRU set thrashes.
  for (const std::uint64_t lines : {1024u, 1025u}) {
    fresh_context();
    L1Bench bench;
    for (unsigned pass = 0; pass < 2; ++pass) {
      for (std::uint64_t i = 0; i < lines; ++i) bench.client().read(10 + (pass * lines + i) * 150, i * 128);
    }
    EXPECT_TRUE(run_until_quiet(bench.clock, 400000));
    EXPECT_TRUE(bench.conserved());
    const std::uint64_t again = lines == 1024 ? 0 : 257;  // the set of lines 0, 4, 8, ... has one line too many
    EXPECT_EQ(bench.l1.counters().region[0].misses, lines + again);
    EXPECT_EQ(bench.l1.counters().region[0].hits, lines - again);
    EXPECT_EQ(bench.l1.counters().evictions, lines == 1024 ? 0u : 258u);
  }
}

}  // namespace
}  // namespace grtx::modules
