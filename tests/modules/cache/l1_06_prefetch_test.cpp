// SPDX-License-Identifier: Apache-2.0
// L1: prefetches are answered like reads and each fetched sector ends as exactly one of useful, late or unused.
#include "grtx/modules/cache/l1_cache.h"
#include "modules/cache/l1_bench.h"

namespace grtx::modules {
namespace {

class L1Prefetch : public SystemCTest {};

TEST_F(L1Prefetch, UsefulLateUnusedAndRedundant) {
  L1Bench bench;
  bench.client().prefetch(10, 0x000);  // useful: referenced after its fill
  bench.client().prefetch(11, 0x020);  // late: referenced while pending
  bench.client().prefetch(12, 0x040);  // unused: never referenced
  bench.client().read(50, 0x020);
  bench.client().read(51, 0x020);      // a second reference of the late one changes nothing
  bench.client().prefetch(52, 0x020);  // redundant: pending
  bench.client().read(500, 0x000);
  bench.client().read(520, 0x000);
  bench.client().prefetch(540, 0x000);  // redundant: present
  EXPECT_TRUE(run_until_quiet(bench.clock, 2000));
  const L1Counters c = bench.l1.counters();
  EXPECT_EQ(c.prefetches, 5u);
  EXPECT_EQ(c.prefetches_redundant, 2u);
  EXPECT_EQ(c.prefetches_fetched, 3u);
  EXPECT_EQ(c.prefetches_useful, 1u);
  EXPECT_EQ(c.prefetches_late, 1u);
  EXPECT_EQ(c.prefetches_unused, 1u);
  EXPECT_EQ(c.region[0].reads, 4u) << "prefetches are not demand reads";
  EXPECT_EQ(c.region[0].misses, 0u);
  EXPECT_EQ(c.region[0].hits_on_miss, 2u);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L1Prefetch, AnEvictedUnreferencedPrefetchIsUnused) {
  L1Cache::Config config;
  config.geometry = {128, 128, 32, 1};
  L1Bench bench(config);
  bench.client().prefetch(10, 0x00);
  bench.client().prefetch(11, 0x20);
  bench.client().read(300, 0x20);
  bench.client().read(600, 0x1000);  // evicts both; one was used
  EXPECT_TRUE(run_until_quiet(bench.clock, 2000));
  EXPECT_EQ(bench.l1.counters().prefetches_useful, 1u);
  EXPECT_EQ(bench.l1.counters().prefetches_unused, 1u);
}

TEST_F(L1Prefetch, ADemandMissThatAPrefetchJoinsIsNotAPrefetchedSector) {
  L1Bench bench;
  bench.client().read(10, 0x20);
  bench.client().prefetch(11, 0x20);
  bench.client().read(500, 0x20);
  EXPECT_TRUE(run_until_quiet(bench.clock, 2000));
  const L1Counters c = bench.l1.counters();
  EXPECT_EQ(c.prefetches_fetched + c.prefetches_useful + c.prefetches_late + c.prefetches_unused, 0u);
  EXPECT_EQ(c.prefetches_redundant, 1u);
}

}  // namespace
}  // namespace grtx::modules
