// SPDX-License-Identifier: Apache-2.0
// Which requests wait for which sector, and when there is no room for one more.
#include "grtx/modules/cache/decide/mshr_table.h"

#include <gtest/gtest.h>

#include <sstream>

namespace grtx::modules {
namespace {

MemoryRequest request(std::uint32_t tag, bool prefetch = false) {
  MemoryRequest request;
  request.tag = tag;
  request.prefetch = prefetch;
  return request;
}

TEST(MshrTable, AMissTakesAnEntryUntilItsSectorHasCome) {
  MshrTable table(2, 4);
  EXPECT_EQ(table.find(640), MshrTable::kNone);
  const std::uint32_t entry = table.allocate(7, 640, request(1));
  EXPECT_EQ(table.find(640), entry);
  EXPECT_EQ(table.sector_address(entry), 640u);
  EXPECT_EQ(table.allocated(entry), 7u);
  EXPECT_TRUE(table.in_use(entry));
  table.release(entry);
  EXPECT_EQ(table.find(640), MshrTable::kNone);
  EXPECT_FALSE(table.in_use(entry));
  EXPECT_EQ(table.used(), 0u);
}

TEST(MshrTable, HasOneEntryForEachSectorOfALine) {
  MshrTable table(2, 4);
  const std::uint32_t first = table.allocate(0, 640, request(1));
  const std::uint32_t next = table.allocate(0, 640 + kSectorBytes, request(2));
  EXPECT_NE(first, next);
  EXPECT_EQ(table.find(640 + kSectorBytes), next);
}

TEST(MshrTable, IsFullWhenEachEntryWaits) {
  MshrTable table(2, 1);
  table.allocate(0, 0, request(1));
  EXPECT_FALSE(table.full());
  const std::uint32_t second = table.allocate(0, 32, request(2));
  EXPECT_TRUE(table.full());
  table.release(second);
  EXPECT_FALSE(table.full());
}

TEST(MshrTable, MergesAsManyRequestsAsAnEntryHoldsTheMissIncluded) {
  MshrTable table(1, 3);
  const std::uint32_t entry = table.allocate(0, 640, request(1));
  table.merge(entry, request(2));
  EXPECT_FALSE(table.merges_full(entry));
  table.merge(entry, request(3));
  EXPECT_TRUE(table.merges_full(entry));
  const auto waiters = table.waiters(entry);
  ASSERT_EQ(waiters.size(), 3u);
  for (std::uint32_t i = 0; i < 3; ++i) EXPECT_EQ(waiters[i].tag, i + 1) << "in the order of their requests";
}

TEST(MshrTable, AnEntryIsDemandedFromItsFirstAccessThatIsNoPrefetch) {
  MshrTable table(1, 3);
  const std::uint32_t entry = table.allocate(0, 640, request(1, true));
  EXPECT_FALSE(table.demanded(entry));
  table.merge(entry, request(2));
  EXPECT_TRUE(table.demanded(entry));
  table.merge(entry, request(3, true));
  EXPECT_TRUE(table.demanded(entry));
}

TEST(MshrTable, AReleasedEntryBeginsAnew) {
  MshrTable table(1, 2);
  const std::uint32_t before = table.allocate(0, 640, request(1));
  table.merge(before, request(2));
  table.release(before);
  const std::uint32_t entry = table.allocate(9, 1280, request(3, true));
  EXPECT_FALSE(table.demanded(entry));
  EXPECT_FALSE(table.merges_full(entry));
  EXPECT_EQ(table.waiters(entry).size(), 1u);
}

TEST(MshrTable, ADumpSaysWhatWaitsSinceWhen) {
  MshrTable table(2, 2);
  table.merge(table.allocate(7, 640, request(1)), request(2));
  std::ostringstream out;
  table.dump_state(out);
  EXPECT_EQ(out.str(), "  mshr 0: sector 0x280 since cycle 7, 2 waiting\n");
}

}  // namespace
}  // namespace grtx::modules
