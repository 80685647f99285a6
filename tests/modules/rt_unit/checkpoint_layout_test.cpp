// Which sectors a lane's checkpoint entries take. Sectors are 32 B. Where entries are 20 B, entry n lies at 20 n, so of
// eight entries (five sectors) numbers 1, 3, 4 and 6 straddle two; of 16 and 8 B none does.
#include "grtx/modules/rt_unit/decide/checkpoint_layout.h"

#include <gtest/gtest.h>

#include <vector>

#include "grtx/base/error.h"

namespace grtx::modules {
namespace {

using Numbers = std::vector<std::uint64_t>;

constexpr unsigned kEntries = 8;
constexpr auto kFifo = traces::CheckpointOrder::fifo;
constexpr auto kLifo = traces::CheckpointOrder::lifo;

/// A layout of entries of 20 B.
CheckpointLayout layout_of(traces::CheckpointOrder order, std::uint64_t capacity, bool write_combine, bool read_buffer,
                           unsigned entry_bytes = 20) {
  CheckpointConfig config;
  config.write_combine = write_combine;
  config.read_buffer = read_buffer;
  config.entry_bytes = entry_bytes;
  traces::Header header;
  header.checkpoint = true;
  header.checkpoint_order = order;
  header.checkpoint_capacity = capacity;
  return {config, header};
}

Numbers numbers(const CheckpointLayout::Sectors& sectors) {
  return {sectors.number.begin(), sectors.number.begin() + sectors.count};
}

/// One more entry, with the sectors that it completes.
CheckpointLayout::Sectors write(CheckpointLayout& layout, CheckpointLayout::Lane& lane) {
  EXPECT_EQ(layout.submit(lane, 1, false, false), 1u);
  return layout.append(lane);
}

std::vector<Numbers> write_all(CheckpointLayout layout) {
  std::vector<Numbers> all;
  CheckpointLayout::Lane lane;
  for (unsigned i = 0; i < kEntries; ++i) all.push_back(numbers(write(layout, lane)));
  return all;
}

std::vector<Numbers> read_all(CheckpointLayout layout) {
  std::vector<Numbers> all;
  CheckpointLayout::Lane lane;
  lane.source_entries = kEntries;
  for (unsigned i = 0; i < kEntries; ++i) all.push_back(numbers(layout.read(lane)));
  return all;
}

TEST(CheckpointLayout, CombinedEntriesWriteEachSectorOnceWhenItIsComplete) {
  EXPECT_EQ(write_all(layout_of(kFifo, kEntries, true, true)),
            (std::vector<Numbers>{{}, {0}, {}, {1}, {2}, {}, {3}, {4}}));
}

TEST(CheckpointLayout, EntriesThatAreNotCombinedWriteWhatTheyTouch) {
  EXPECT_EQ(write_all(layout_of(kFifo, kEntries, false, true)),
            (std::vector<Numbers>{{0}, {0, 1}, {1}, {1, 2}, {2, 3}, {3}, {3, 4}, {4}}));
}

TEST(CheckpointLayout, OnlyTheLastSectorOfEntriesThatEndWithinOneIsOpen) {
  CheckpointLayout layout = layout_of(kFifo, kEntries, true, true);
  CheckpointLayout::Lane lane;
  EXPECT_EQ(layout.open_sector(lane), CheckpointLayout::kNoSector) << "nothing written";
  std::vector<std::uint64_t> open;
  for (unsigned i = 0; i < kEntries; ++i) {
    write(layout, lane);
    open.push_back(layout.open_sector(lane));
  }
  EXPECT_EQ(open, (std::vector<std::uint64_t>{0, 1, 1, 2, 3, 3, 4, CheckpointLayout::kNoSector}));
  EXPECT_EQ(layout_of(kFifo, kEntries, false, true).open_sector(lane), CheckpointLayout::kNoSector);
}

TEST(CheckpointLayout, AHeldSectorIsNotReadAgain) {
  EXPECT_EQ(read_all(layout_of(kFifo, kEntries, true, true)),
            (std::vector<Numbers>{{0}, {1}, {}, {2}, {3}, {}, {4}, {}}));
}

TEST(CheckpointLayout, LifoReadsFromTheEndAndKeepsTheLowerSector) {
  EXPECT_EQ(read_all(layout_of(kLifo, kEntries, true, true)),
            (std::vector<Numbers>{{4}, {3}, {}, {2}, {1}, {}, {0}, {}}));
}

TEST(CheckpointLayout, WithoutReadBufferTheSharedSectorIsReadLast) {
  EXPECT_EQ(read_all(layout_of(kFifo, kEntries, true, false)),
            (std::vector<Numbers>{{0}, {0, 1}, {1}, {1, 2}, {2, 3}, {3}, {3, 4}, {4}}));
  EXPECT_EQ(read_all(layout_of(kLifo, kEntries, true, false)),
            (std::vector<Numbers>{{4}, {4, 3}, {3}, {3, 2}, {2, 1}, {1}, {1, 0}, {0}}));
}

TEST(CheckpointLayout, StraddlingEntriesSaySo) {
  CheckpointLayout layout = layout_of(kFifo, kEntries, true, true);
  CheckpointLayout::Lane lane;
  std::vector<bool> written, read;
  for (unsigned i = 0; i < kEntries; ++i) {
    written.push_back(write(layout, lane).straddles);
    read.push_back(layout.read(lane).straddles);
  }
  EXPECT_EQ(written, (std::vector<bool>{false, true, false, true, true, false, true, false}));
  EXPECT_EQ(read, written);
}

TEST(CheckpointLayout, EntriesOf16And8BytesNeverStraddle) {
  for (const bool combine : {false, true}) {
    SCOPED_TRACE(combine);
    const CheckpointLayout of_16 = layout_of(kFifo, kEntries, combine, combine, 16);
    const CheckpointLayout of_8 = layout_of(kFifo, kEntries, combine, combine, 8);
    EXPECT_EQ(of_16.most_sectors(), 1u);
    EXPECT_EQ(of_8.most_sectors(), 1u);
    if (combine) {
      EXPECT_EQ(write_all(of_16), (std::vector<Numbers>{{}, {0}, {}, {1}, {}, {2}, {}, {3}}));
      EXPECT_EQ(write_all(of_8), (std::vector<Numbers>{{}, {}, {}, {0}, {}, {}, {}, {1}}));
      EXPECT_EQ(read_all(of_16), (std::vector<Numbers>{{0}, {}, {1}, {}, {2}, {}, {3}, {}}));
      EXPECT_EQ(read_all(of_8), (std::vector<Numbers>{{0}, {}, {}, {}, {1}, {}, {}, {}}));
    } else {
      const std::vector<Numbers> halves = {{0}, {0}, {1}, {1}, {2}, {2}, {3}, {3}};
      const std::vector<Numbers> quarters = {{0}, {0}, {0}, {0}, {1}, {1}, {1}, {1}};
      EXPECT_EQ(write_all(of_16), halves);
      EXPECT_EQ(read_all(of_16), halves);
      EXPECT_EQ(write_all(of_8), quarters);
      EXPECT_EQ(read_all(of_8), quarters);
    }
  }
}

TEST(CheckpointLayout, RoundsTakeTurnsWithTheTwoBuffers) {
  traces::Header header;
  header.checkpoint = true;
  header.checkpoint_capacity = kEntries;
  header.warp_size = 32;
  const MemoryMap map(header, {1, 2, 0, 0});
  CheckpointLayout layout = layout_of(kFifo, kEntries, true, true);
  const auto even = layout.begin(map, 0, 0, 5, 2, true, 0), odd = layout.begin(map, 0, 0, 5, 3, true, 0);
  EXPECT_EQ(even.destination, odd.source);
  EXPECT_EQ(even.source, odd.destination);
  EXPECT_NE(even.source, even.destination);
}

TEST(CheckpointLayout, OnlyReferencesNeedTheOrderOfWriting) {
  using traces::CheckpointOrder;
  for (const CheckpointOrder order : {CheckpointOrder::fifo, CheckpointOrder::lifo, CheckpointOrder::nearest}) {
    traces::Header header;
    header.checkpoint = true;
    header.checkpoint_order = order;
    header.checkpoint_capacity = kEntries;
    CheckpointConfig config;
    EXPECT_NO_THROW(CheckpointLayout(config, header));
    config.forward = CheckpointForward::reference;
    if (order == CheckpointOrder::nearest) {
      EXPECT_THROW(CheckpointLayout(config, header), Error);
    } else {
      EXPECT_NO_THROW(CheckpointLayout(config, header));
    }
  }
}

TEST(CheckpointLayout, NothingLiesBeyondTheCapacity) {
  CheckpointLayout layout = layout_of(kFifo, 1, true, true);
  CheckpointLayout::Lane lane;
  write(layout, lane);
  layout.read(lane);
  EXPECT_THROW(write(layout, lane), Error);
  EXPECT_THROW(layout.read(lane), Error);
  CheckpointLayout::Lane empty;
  EXPECT_THROW(layout_of(kLifo, 1, true, true).read(empty), Error) << "reads before the first";
}

}  // namespace
}  // namespace grtx::modules
