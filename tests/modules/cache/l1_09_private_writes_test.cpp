// SPDX-License-Identifier: Apache-2.0
// L1: private buffers by policy: written through or back, with or without a line of their own; what is dirty reaches
// the memory when its line goes, and a fill never waits for that.
#include "grtx/modules/cache/l1_cache.h"
#include "modules/cache/l1_bench.h"

namespace grtx::modules {
namespace {

class L1PrivateWrites : public SystemCTest {
 protected:
  static L1Cache::Config config(WritePolicy policy, bool allocate) {
    L1Cache::Config config;
    config.private_writes = {policy, allocate};
    return config;
  }
};

TEST_F(L1PrivateWrites, OnlyBuffersOfOneRayOrWarpAreKept) {
  for (std::size_t i = 0; i < kRegionCount; ++i) {
    const auto region = static_cast<Region>(i);
    const bool own = region == Region::checkpoint || region == Region::eviction || region == Region::k_buffer ||
                     region == Region::stack;
    for (const bool allocate : {false, true}) {
      for (const bool present : {false, true}) {
        const auto through = PrivateWrites{WritePolicy::write_through, allocate}.effect(region, present);
        EXPECT_EQ(through.keep, own && allocate);
        EXPECT_FALSE(through.dirty);
        EXPECT_TRUE(through.forward);
        const auto back = PrivateWrites{WritePolicy::write_back, allocate}.effect(region, present);
        EXPECT_EQ(back.keep, own && (allocate || present)) << name_at<Region>(i);
        EXPECT_EQ(back.dirty, back.keep);
        EXPECT_EQ(back.forward, !back.dirty);
      }
    }
  }
}

TEST_F(L1PrivateWrites, AKeptWriteIsAnsweredAsAHitAndNothingLeaves) {
  L1Bench bench(config(WritePolicy::write_back, true));
  const auto first = bench.client().write(10, 0x80, Region::checkpoint);
  const auto again = bench.client().write(100, 0x80, Region::checkpoint);
  const auto read = bench.client().read(200, 0x80, Region::checkpoint);
  EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
  EXPECT_EQ(bench.client().answered(first), 10 + bench.l1.config().latency);
  EXPECT_EQ(bench.client().answered(again), 100 + bench.l1.config().latency);
  EXPECT_EQ(bench.client().answered(read), 200 + bench.l1.config().latency);
  EXPECT_TRUE(bench.memory.arrivals().empty());
  const L1Counters counters = bench.l1.counters();
  EXPECT_EQ(counters.kept_writes, 2u);
  EXPECT_EQ(counters.rewrites, 1u);
  EXPECT_EQ(counters.write_backs, 0u);
  EXPECT_EQ(bench.l1.dirty_sectors(), 1u);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L1PrivateWrites, AKeptWriteNeedsNoRoomOnTheWayOut) {
  L1Cache::Config configured = config(WritePolicy::write_back, true);
  configured.miss_queue = configured.geometry.sectors();
  configured.tag_latency = 100;  // misses stay in their queue
  L1Bench bench(configured);
  bench.client().write(10, 0x80, Region::k_buffer);
  for (unsigned i = 0; i < configured.miss_queue; ++i) bench.client().read(20 + i, 0x1000 + 32 * i, Region::leaf);
  const auto kept = bench.client().write(40, 0x80, Region::k_buffer);
  EXPECT_TRUE(run_until_quiet(bench.clock, 2000));
  EXPECT_EQ(bench.client().answered(kept), 40 + configured.latency);
  EXPECT_EQ(bench.l1.counters().kept_writes, 2u);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L1PrivateWrites, WithoutAllocationOnlyAPresentLineKeepsAWrite) {
  L1Bench bench(config(WritePolicy::write_back, false));
  bench.client().write(10, 0x80, Region::stack);    // absent: goes on
  bench.client().read(500, 0xA0, Region::stack);    // brings the line, not the sector at 0x80
  bench.client().write(1000, 0x80, Region::stack);  // stays
  const auto read = bench.client().read(1100, 0x80, Region::stack);
  EXPECT_TRUE(run_until_quiet(bench.clock, 3000));
  EXPECT_EQ(bench.memory.arrivals().size(), 2u);
  EXPECT_EQ(bench.client().answered(read), 1100 + bench.l1.config().latency);
  EXPECT_EQ(bench.l1.counters().kept_writes, 1u);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L1PrivateWrites, ThroughWithAllocationKeepsTheSectorCleanAndSendsIt) {
  L1Bench bench(config(WritePolicy::write_through, true));
  const auto write = bench.client().write(10, 0x80, Region::eviction);
  const auto read = bench.client().read(12, 0x80, Region::eviction);
  EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
  ASSERT_EQ(bench.memory.arrivals().size(), 1u);
  EXPECT_TRUE(bench.memory.arrivals()[0].request.write);
  EXPECT_FALSE(bench.memory.arrivals()[0].request.write_back);
  EXPECT_EQ(bench.client().answered(write), 10 + l1_miss_latency(bench.l1.config(), L1Bench::kMemoryLatency));
  EXPECT_EQ(bench.client().answered(read), 12 + bench.l1.config().latency);
  EXPECT_EQ(bench.l1.dirty_sectors(), 0u);
}

TEST_F(L1PrivateWrites, AnEvictedLineSendsItsDirtySectorsAndNobodyIsAnswered) {
  L1Cache::Config small = config(WritePolicy::write_back, true);
  small.geometry = {256, 128, 32, 2};
  small.sm = 7;
  L1Bench bench(small);
  bench.client().write(10, 0x000, Region::checkpoint);
  bench.client().write(20, 0x040, Region::checkpoint);
  bench.client().write(30, 0x080, Region::k_buffer);
  bench.client().write(100, 0x100, Region::eviction);  // takes the place of line 0
  EXPECT_TRUE(run_until_quiet(bench.clock, 2000));
  const auto& arrivals = bench.memory.arrivals();
  ASSERT_EQ(arrivals.size(), 2u);
  EXPECT_EQ(arrivals[0].request.address, 0x000u);
  EXPECT_EQ(arrivals[1].request.address, 0x040u);
  for (const auto& arrival : arrivals) {
    EXPECT_TRUE(arrival.request.write && arrival.request.write_back);
    EXPECT_EQ(arrival.request.region, Region::checkpoint);
    EXPECT_EQ(arrival.request.sm, 7);
  }
  const L1Counters counters = bench.l1.counters();
  EXPECT_EQ(counters.write_backs, 2u);
  EXPECT_EQ(counters.kept_writes, counters.write_backs + bench.l1.dirty_sectors());
  EXPECT_EQ(bench.client().answers().size(), 4u);
  EXPECT_TRUE(bench.conserved());
}

// Until the write-back buffer a fill whose victim was dirty needed room in the miss queue, which others had taken
// first.
TEST_F(L1PrivateWrites, AFullMissQueueDropsNoFill) {
  L1Cache::Config small = config(WritePolicy::write_back, true);
  small.geometry = {128, 128, 32, 1};  // one line
  small.miss_queue = 1;
  small.write_back_buffer = 1;
  L1Bench bench(small);
  const auto read = bench.client().read(10, 0x1000);  // its fill comes when the only line is dirty, the queue full
  for (unsigned sector = 0; sector < 4; ++sector) bench.client().write(20 + sector, sector * 32, Region::stack);
  bench.memory.takes = [](Cycle now) { return now < 40 || now > 400; };
  std::vector<std::uint64_t> ahead;
  for (unsigned i = 0; i < 12; ++i) {  // eight for the link behind the queue
    ahead.push_back(0x4000 + 128 * i);
    bench.client().at(50 + i, {.address = ahead.back(), .region = Region::ray, .write = true});
  }
  EXPECT_TRUE(run_until_quiet(bench.clock, 4000));
  EXPECT_LT(bench.client().answered(read), 400u);
  EXPECT_EQ(bench.l1.counters().fills_bypassed, 0u);
  EXPECT_EQ(bench.l1.counters().write_backs, 4u);
  EXPECT_EQ(bench.l1.dirty_sectors(), 0u);
  // The dirty sectors leave behind what was in the miss queue before them, and before what came after them.
  std::size_t place = 0;
  const auto& arrivals = bench.memory.arrivals();
  while (place < arrivals.size() && !arrivals[place].request.write_back) ++place;
  ASSERT_LT(place + 4, arrivals.size());
  for (std::uint64_t sector = 0; sector < 4; ++sector) {
    EXPECT_EQ(arrivals[place + sector].request.address, sector * 32);
    EXPECT_TRUE(arrivals[place + sector].request.write_back);
  }
  EXPECT_EQ(arrivals[place + 4].request.address, ahead[place - 1]);  // the first arrival is the read
  EXPECT_TRUE(bench.conserved());
}

// A dirty line whose turn it was blocked its set: its fills were dropped until the buffer had room again.
TEST_F(L1PrivateWrites, ADirtyLineWithoutAWayOutDropsNoFillOfASetWithACleanOne) {
  L1Cache::Config small = config(WritePolicy::write_back, true);
  small.geometry = {512, 128, 32, 4};
  small.write_back_buffer = 1;
  L1Bench bench(small);
  bench.memory.takes = [](Cycle now) { return now < 300 || now > 900; };
  const auto line = [](unsigned number) { return std::uint64_t{number} * 128; };
  bench.client().write(10, line(0), Region::stack);
  bench.client().write(20, line(1), Region::stack);
  bench.client().read(30, line(2));
  bench.client().read(40, line(3));
  const auto fourth = bench.client().read(250, line(4));
  const auto fifth = bench.client().read(251, line(5));
  for (unsigned i = 0; i < 8; ++i) {  // the link is full when the two are answered
    bench.client().at(300 + i, {.address = 0x4000 + 128 * i, .region = Region::ray, .write = true});
  }
  // Line 4 has sent line 0 to the buffer. Line 5 has taken the place of line 2, not of line 1: those are here.
  std::vector<std::uint32_t> hits;
  for (const unsigned number : {1U, 3U, 4U, 5U}) hits.push_back(bench.client().read(400 + 2 * number, line(number)));
  bench.client().read(1200, line(2));
  EXPECT_TRUE(run_until_quiet(bench.clock, 4000));
  EXPECT_LT(bench.client().answered(fourth), 400u);
  EXPECT_LT(bench.client().answered(fifth), 400u);
  for (std::size_t i = 0; i < hits.size(); ++i) EXPECT_LT(bench.client().answered(hits[i]), 500u) << i;
  const L1Counters counters = bench.l1.counters();
  EXPECT_EQ(counters.fills_bypassed, 0u);
  EXPECT_EQ(counters.all().hits, hits.size());
  EXPECT_EQ(counters.all().misses, 5u);
  EXPECT_EQ(counters.write_backs + bench.l1.dirty_sectors(), 2u);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L1PrivateWrites, AFillIsAnsweredAndNotKeptWhereAllLinesOfItsSetAreDirtyAndHaveNoWayOut) {
  for (const unsigned lines : {1U, 2U}) {
    fresh_context();
    L1Cache::Config small = config(WritePolicy::write_back, true);
    small.geometry = {128, 128, 32, 1};
    small.write_back_buffer = lines;
    L1Bench bench(small);
    bench.memory.takes = [](Cycle now) { return now < 45 || now > 400; };
    bench.client().read(10, 0x1000);
    bench.client().write(20, 0x000, Region::stack);
    const auto read = bench.client().read(40, 0x2000);
    for (unsigned i = 0; i < 8; ++i) {  // the link is full
      bench.client().at(50 + i, {.address = 0x4000 + 128 * i, .region = Region::ray, .write = true});
    }
    bench.client().write(125, 0x080, Region::stack);  // between the two fills: the first has sent line 0 to the buffer
    EXPECT_TRUE(run_until_quiet(bench.clock, 4000));
    EXPECT_LT(bench.client().answered(read), 400u);
    const L1Counters counters = bench.l1.counters();
    EXPECT_EQ(counters.fills, 2u);
    EXPECT_EQ(counters.fills_bypassed, 2 - lines);
    EXPECT_EQ(counters.write_backs, lines);
    EXPECT_EQ(bench.l1.dirty_sectors(), 2 - lines);
    EXPECT_TRUE(bench.conserved());
  }
}

TEST_F(L1PrivateWrites, AWriteThatNeedsALineWaitsForRoomInTheBuffer) {
  L1Cache::Config small = config(WritePolicy::write_back, true);
  small.geometry = {128, 128, 32, 1};
  small.write_back_buffer = 1;
  L1Bench bench(small);
  bench.memory.takes = [](Cycle now) { return now > 400; };
  for (unsigned i = 0; i < 10; ++i) {  // the link is full
    bench.client().at(10 + i, {.address = 0x4000 + 128 * i, .region = Region::ray, .write = true});
  }
  bench.client().write(40, 0x000, Region::stack);
  const auto second = bench.client().write(41, 0x080, Region::stack);  // the buffer takes line 0
  const auto third = bench.client().write(42, 0x100, Region::stack);   // and has no room for this one's
  EXPECT_TRUE(run_until_quiet(bench.clock, 4000));
  EXPECT_EQ(bench.client().answered(second), 41 + small.latency);
  EXPECT_GT(bench.client().answered(third), 400u);
  EXPECT_EQ(bench.l1.counters().write_backs, 2u);
  EXPECT_TRUE(bench.conserved());
}

TEST_F(L1PrivateWrites, OnlyWhatWritesBackPaysForABuffer) {
  const auto buffer_bits = [](WritePolicy policy, unsigned lines) {
    fresh_context();
    L1Cache::Config configured = config(policy, false);
    configured.write_back_buffer = lines;
    L1Bench bench(configured);
    std::uint64_t bits = 0;
    for (const auto& storage : bench.l1.inventory().storage) {
      if (storage.name == "write_back_buffer") bits += storage.bits;
    }
    return bits;
  };
  EXPECT_EQ(buffer_bits(WritePolicy::write_through, 16), 0u);
  EXPECT_GE(buffer_bits(WritePolicy::write_back, 16), 16u * 128 * 8);
  EXPECT_EQ(buffer_bits(WritePolicy::write_back, 16), 2 * buffer_bits(WritePolicy::write_back, 8));
}

}  // namespace
}  // namespace grtx::modules
