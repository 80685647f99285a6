// SPDX-License-Identifier: Apache-2.0
// The load-store unit: oldest sector first, one per cycle, nothing lost when the L1 takes none; coalescing.
#include <gtest/gtest.h>

#include "grtx/modules/simt/load_store_unit.h"

namespace grtx::modules {
namespace {

std::vector<SectorAccess> sectors(std::uint64_t first, unsigned n, Region region = Region::k_buffer) {
  std::vector<SectorAccess> list;
  for (unsigned i = 0; i < n; ++i) list.push_back({(first + i) * kSectorBytes, region});
  return list;
}

TEST(LoadStoreUnit, SendsOldestFirstOneACycleWithTagAndClient) {
  LoadStoreUnit lsu(32, 1);
  Link<MemoryRequest> link("requests", 1, 64);
  lsu.enqueue(7, sectors(100, 2), false);
  lsu.enqueue(3, sectors(200, 1, Region::ray), true);
  for (Cycle now = 10; now < 13; ++now) EXPECT_TRUE(lsu.send(now, link));
  EXPECT_FALSE(lsu.send(13, link));
  const struct {
    std::uint64_t sector;
    unsigned slot;
    bool write;
    Region region;
  } expected[] = {{100, 7, false, Region::k_buffer}, {101, 7, false, Region::k_buffer}, {200, 3, true, Region::ray}};
  for (unsigned i = 0; i < 3; ++i) {
    const MemoryRequest* request = link.front(11 + i);
    ASSERT_NE(request, nullptr);
    EXPECT_EQ(request->address, expected[i].sector * kSectorBytes);
    EXPECT_EQ(request->tag, expected[i].slot);
    EXPECT_EQ(request->client, 1);
    EXPECT_EQ(request->write, expected[i].write);
    EXPECT_EQ(request->region, expected[i].region);
    link.pop(11 + i);
  }
  EXPECT_EQ(lsu.in_flight(), 3u);
}

TEST(LoadStoreUnit, KeepsARequestThatTheL1DoesNotTake) {
  LoadStoreUnit lsu(32, 1);
  Link<MemoryRequest> link("requests", 1, 1);
  lsu.enqueue(0, sectors(1, 2), false);
  EXPECT_TRUE(lsu.send(0, link));
  EXPECT_FALSE(lsu.send(1, link));
  EXPECT_FALSE(lsu.send(2, link));
  link.pop(2);
  EXPECT_FALSE(lsu.send(2, link));  // space is seen a cycle later
  EXPECT_TRUE(lsu.send(3, link));
  EXPECT_EQ(link.front(4)->address, 2 * kSectorBytes);
  EXPECT_EQ(lsu.counters().blocked_cycles, 3u);
}

TEST(LoadStoreUnit, CountsLoadsAndStoresOfAWarpApart) {
  LoadStoreUnit lsu(2, 0);
  Link<MemoryRequest> link("requests", 1, 8);
  lsu.enqueue(1, sectors(0, 2), false);
  lsu.enqueue(1, sectors(9, 1, Region::eviction), true);
  EXPECT_EQ(lsu.loads_pending(1), 2u);
  EXPECT_EQ(lsu.stores_pending(1), 1u);
  EXPECT_EQ(lsu.loads_pending(0), 0u);
  for (Cycle now = 0; now < 3; ++now) lsu.send(now, link);
  MemoryResponse response{.tag = 1};
  EXPECT_EQ(lsu.receive(response), 1u);
  response.write = true;
  EXPECT_EQ(lsu.receive(response), 1u);
  EXPECT_EQ(lsu.loads_pending(1), 1u);
  EXPECT_EQ(lsu.stores_pending(1), 0u);
  EXPECT_FALSE(lsu.idle());
  response.write = false;
  lsu.receive(response);
  EXPECT_TRUE(lsu.idle());
  EXPECT_EQ(lsu.counters().loads[static_cast<std::size_t>(Region::k_buffer)], 2u);
  EXPECT_EQ(lsu.counters().stores[static_cast<std::size_t>(Region::eviction)], 1u);
}

TEST(LoadStoreUnit, QueueGrowsWithoutLosingOrder) {
  LoadStoreUnit lsu(1, 0);
  Link<MemoryRequest> link("requests", 1, 2);
  std::uint64_t sent = 0;
  std::uint64_t queued = 0;
  for (Cycle now = 0; sent < 6000; ++now) {
    if (queued < 6000 && now % 3 == 0) {  // 12 in, 3 out: wraps around and outgrows the first ring
      lsu.enqueue(0, sectors(queued, 12), false);
      queued += 12;
    }
    if (const MemoryRequest* request = link.front(now)) {
      ASSERT_EQ(request->address, sent * kSectorBytes);
      ++sent;
      link.pop(now);
    }
    lsu.send(now, link);
  }
  EXPECT_EQ(lsu.queued(), 0u);
  EXPECT_GT(lsu.counters().deepest_queue, 1024u);
}

TEST(Coalescer, MergesWithinAnInstructionNotAcross) {
  Coalescer coalescer(64);
  std::vector<SectorAccess> out;
  coalescer.begin(Region::gaussian, out);
  coalescer.touch(40, 8);   // sector 1
  coalescer.touch(96, 48);  // sectors 3 and 4
  coalescer.touch(33, 1);   // sector 1 again, not neighbouring in time
  coalescer.touch(63, 2);   // straddles 1 and 2
  EXPECT_EQ(out, (std::vector<SectorAccess>{
                     {32, Region::gaussian}, {96, Region::gaussian}, {128, Region::gaussian}, {64, Region::gaussian}}));
  coalescer.begin(Region::sh, out);
  coalescer.touch(32, 4);
  EXPECT_EQ(out.size(), 5u);
  EXPECT_EQ(out.back(), (SectorAccess{32, Region::sh}));
}

TEST(Coalescer, AgreesWithASetForManyScatteredTouches) {
  Coalescer coalescer(400);
  std::uint64_t state = 11;
  for (int round = 0; round < 200; ++round) {
    std::vector<SectorAccess> out;
    std::vector<std::uint64_t> expected;
    coalescer.begin(Region::sh, out);
    for (int i = 0; i < 50; ++i) {
      state = state * 6364136223846793005ULL + 1442695040888963407ULL;
      const std::uint64_t address = (state >> 40) % 20000;
      const std::uint64_t bytes = 1 + (state >> 20) % 192;
      coalescer.touch(address, bytes);
      for (std::uint64_t s = address / 32; s <= (address + bytes - 1) / 32; ++s) {
        if (std::find(expected.begin(), expected.end(), s * 32) == expected.end()) expected.push_back(s * 32);
      }
    }
    ASSERT_EQ(out.size(), expected.size());
    for (std::size_t i = 0; i < out.size(); ++i) ASSERT_EQ(out[i].address, expected[i]);
  }
}

}  // namespace
}  // namespace grtx::modules
