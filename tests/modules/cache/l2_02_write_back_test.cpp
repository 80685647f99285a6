// SPDX-License-Identifier: Apache-2.0
// L2 slice: writes allocate without a fetch, stay until eviction, and exactly the dirty sectors go to DRAM.
#include "grtx/modules/cache/l2_slice.h"
#include "modules/cache/l2_bench.h"

namespace grtx::modules {
namespace {

class L2WriteBack : public SystemCTest {
 protected:
  /// One set of two ways.
  static L2Slice::Config tiny() {
    L2Slice::Config config = L2Bench::one_slice();
    config.geometry = {256, 128, 32, 2};
    return config;
  }
};

TEST_F(L2WriteBack, AWriteIsAnsweredAtTheHitLatencyWithoutDram) {
  L2Bench bench;
  const auto write = bench.client.write(10, 0x40);
  const auto read = bench.client.read(300, 0x40);
  const auto other_sector = bench.client.read(600, 0x60);
  EXPECT_TRUE(run_until_quiet(bench.core, 10000));
  EXPECT_EQ(bench.client.answered(write), 10u + 165 + 1);
  EXPECT_EQ(bench.client.answered(read), 300u + 165 + 1) << "a full-sector write makes the sector readable";
  EXPECT_GT(bench.client.answered(other_sector), 600u + 165 + 1) << "its neighbours must be fetched";
  EXPECT_EQ(bench.l2.counters().dram_writes, 0u);
  EXPECT_EQ(bench.l2.dirty_sectors(), 1u);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L2WriteBack, EvictionWritesTheDirtySectorsOnly) {
  L2Bench bench(tiny());
  bench.client.write(10, 0x00);
  bench.client.write(20, 0x60);
  bench.client.read(500, 0x20);    // a clean sector of the same line
  bench.client.read(1500, 0x80);   // the other way
  bench.client.read(2500, 0x100);  // evicts line 0: two dirty sectors
  bench.client.read(3500, 0x180);  // evicts the clean line 0x80
  EXPECT_TRUE(run_until_quiet(bench.core, 10000));
  const L2Counters& c = bench.l2.counters();
  EXPECT_EQ(c.evictions, 2u);
  EXPECT_EQ(c.dram_writes, 2u);
  EXPECT_EQ(c.dram_reads, 4u);
  EXPECT_EQ(bench.l2.dirty_sectors(), 0u);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L2WriteBack, AWriteThatEvictsADirtyLine) {
  L2Bench bench(tiny());
  for (unsigned i = 0; i < 6; ++i) bench.client.write(10 + i, i * 128);
  EXPECT_TRUE(run_until_quiet(bench.core, 10000));
  EXPECT_EQ(bench.l2.counters().dram_writes, 4u);
  EXPECT_EQ(bench.l2.dirty_sectors(), 2u);
  EXPECT_EQ(bench.client.answers().back().cycle, 15u + 165 + 1);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L2WriteBack, WhatIsPreloadedIsThereWithoutTrafficInPlaceOfACleanLine) {
  L2Bench bench(tiny());
  bench.l2.preload(0x20);
  const auto there = bench.client.read(10, 0x20);
  const auto neighbour = bench.client.read(500, 0x40);
  bench.client.write(2000, 0x80);
  EXPECT_TRUE(run_until_quiet(bench.core, 3000));
  EXPECT_EQ(bench.client.answered(there), 10u + 165 + 1);
  EXPECT_GT(bench.client.answered(neighbour), 500u + 165 + 1) << "only the sector";
  EXPECT_EQ(bench.l2.counters().dram_reads, 1u);
  bench.l2.preload(0x20);   // line 0 is used last now
  bench.l2.preload(0x100);  // in its place all the same: the other is dirty
  EXPECT_EQ(bench.l2.dirty_sectors(), 1u);
  EXPECT_EQ(bench.l2.counters().dram_writes, 0u);
  EXPECT_EQ(bench.l2.counters().evictions, 0u);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L2WriteBack, WriteBackAddressesAreGlobal) {
  // Slice 2 of 4 with the XOR hash: what it writes back must lie in its own channel.
  L2Slice::Config config;
  config.slice = 2;
  config.interleave.xor_hash = true;
  for (std::uint64_t address = 0; address < 1 << 20; address += 224) {
    const unsigned slice = config.interleave.slice(address);
    ASSERT_LT(slice, 4u);
    ASSERT_EQ(config.interleave.global(config.interleave.local(address), slice), address);
  }
  for (unsigned slices : {1u, 2u, 3u, 6u, 8u}) {
    const AddressInterleave interleave{.slices = slices};
    std::uint64_t next_local = 0;
    for (std::uint64_t address = 0; address < 1 << 18; address += 256) {
      const unsigned slice = interleave.slice(address);
      ASSERT_EQ(interleave.global(interleave.local(address), slice), address);
      if (slice == slices - 1) {
        ASSERT_EQ(interleave.local(address), next_local) << "local addresses are compact";
        next_local += 256;
      }
    }
  }
}

TEST_F(L2WriteBack, AWriteDuringAPendingFetchStaysDirty) {
  L2Bench bench(tiny());
  bench.client.read(10, 0x00);
  bench.client.write(20, 0x00);
  bench.client.read(2000, 0x80);
  bench.client.read(3000, 0x100);  // evicts line 0
  EXPECT_TRUE(run_until_quiet(bench.core, 10000));
  EXPECT_EQ(bench.l2.counters().dram_writes, 1u);
  EXPECT_TRUE(bench.conserved());
}

}  // namespace
}  // namespace grtx::modules
