// Which sectors a lane's checkpoint entries take. Entries are 20 B, sectors 32 B: entry n lies at 20 n, so of eight
// entries (five sectors) numbers 1, 3, 4 and 6 straddle two.
#include "grtx/modules/rt_unit/checkpoint_layout.h"

#include <gtest/gtest.h>

#include <vector>

#include "grtx/base/error.h"

namespace grtx::modules {
namespace {

using Numbers = std::vector<std::uint64_t>;

constexpr unsigned kEntries = 8;
constexpr auto kFifo = traces::CheckpointOrder::fifo;
constexpr auto kLifo = traces::CheckpointOrder::lifo;

Numbers numbers(const CheckpointLayout::Sectors& sectors) {
  return {sectors.number.begin(), sectors.number.begin() + sectors.count};
}

std::vector<Numbers> write_all(const CheckpointLayout& layout) {
  std::vector<Numbers> all;
  CheckpointLayout::Lane lane;
  for (unsigned i = 0; i < kEntries; ++i) all.push_back(numbers(layout.write(lane)));
  return all;
}

std::vector<Numbers> read_all(const CheckpointLayout& layout) {
  std::vector<Numbers> all;
  CheckpointLayout::Lane lane;
  lane.source_entries = kEntries;
  for (unsigned i = 0; i < kEntries; ++i) all.push_back(numbers(layout.read(lane)));
  return all;
}

TEST(CheckpointLayout, CombinedEntriesWriteEachSectorOnceWhenItIsComplete) {
  EXPECT_EQ(write_all({kFifo, kEntries, true, true}), (std::vector<Numbers>{{}, {0}, {}, {1}, {2}, {}, {3}, {4}}));
}

TEST(CheckpointLayout, EntriesThatAreNotCombinedWriteWhatTheyTouch) {
  EXPECT_EQ(write_all({kFifo, kEntries, false, true}),
            (std::vector<Numbers>{{0}, {0, 1}, {1}, {1, 2}, {2, 3}, {3}, {3, 4}, {4}}));
}

TEST(CheckpointLayout, OnlyTheLastSectorOfEntriesThatEndWithinOneIsOpen) {
  const CheckpointLayout layout(kFifo, kEntries, true, true);
  CheckpointLayout::Lane lane;
  EXPECT_EQ(layout.open_sector(lane), CheckpointLayout::kNoSector) << "nothing written";
  std::vector<std::uint64_t> open;
  for (unsigned i = 0; i < kEntries; ++i) {
    layout.write(lane);
    open.push_back(layout.open_sector(lane));
  }
  EXPECT_EQ(open, (std::vector<std::uint64_t>{0, 1, 1, 2, 3, 3, 4, CheckpointLayout::kNoSector}));
  EXPECT_EQ(CheckpointLayout(kFifo, kEntries, false, true).open_sector(lane), CheckpointLayout::kNoSector);
}

TEST(CheckpointLayout, AHeldSectorIsNotReadAgain) {
  EXPECT_EQ(read_all({kFifo, kEntries, true, true}), (std::vector<Numbers>{{0}, {1}, {}, {2}, {3}, {}, {4}, {}}));
}

TEST(CheckpointLayout, LifoReadsFromTheEndAndKeepsTheLowerSector) {
  EXPECT_EQ(read_all({kLifo, kEntries, true, true}), (std::vector<Numbers>{{4}, {3}, {}, {2}, {1}, {}, {0}, {}}));
}

TEST(CheckpointLayout, WithoutReadBufferTheSharedSectorIsReadLast) {
  EXPECT_EQ(read_all({kFifo, kEntries, true, false}),
            (std::vector<Numbers>{{0}, {0, 1}, {1}, {1, 2}, {2, 3}, {3}, {3, 4}, {4}}));
  EXPECT_EQ(read_all({kLifo, kEntries, true, false}),
            (std::vector<Numbers>{{4}, {4, 3}, {3}, {3, 2}, {2, 1}, {1}, {1, 0}, {0}}));
}

TEST(CheckpointLayout, StraddlingEntriesSaySo) {
  const CheckpointLayout layout(kFifo, kEntries, true, true);
  CheckpointLayout::Lane lane;
  std::vector<bool> written, read;
  for (unsigned i = 0; i < kEntries; ++i) {
    written.push_back(layout.write(lane).straddles);
    read.push_back(layout.read(lane).straddles);
  }
  EXPECT_EQ(written, (std::vector<bool>{false, true, false, true, true, false, true, false}));
  EXPECT_EQ(read, written);
}

TEST(CheckpointLayout, RoundsTakeTurnsWithTheTwoBuffers) {
  traces::Header header;
  header.checkpoint = true;
  header.checkpoint_capacity = kEntries;
  header.warp_size = 32;
  const MemoryMap map(header, {1, 2, 0, 0});
  const CheckpointLayout layout(kFifo, kEntries, true, true);
  const auto even = layout.begin(map, 5, 2, 0), odd = layout.begin(map, 5, 3, 0);
  EXPECT_EQ(even.destination, odd.source);
  EXPECT_EQ(even.source, odd.destination);
  EXPECT_NE(even.source, even.destination);
}

TEST(CheckpointLayout, NothingLiesBeyondTheCapacity) {
  const CheckpointLayout layout(kFifo, 1, true, true);
  CheckpointLayout::Lane lane;
  layout.write(lane);
  layout.read(lane);
  EXPECT_THROW(layout.write(lane), Error);
  EXPECT_THROW(layout.read(lane), Error);
  CheckpointLayout::Lane empty;
  EXPECT_THROW(CheckpointLayout(kLifo, 1, true, true).read(empty), Error) << "reads before the first";
}

}  // namespace
}  // namespace grtx::modules
