// SPDX-License-Identifier: Apache-2.0
// Which sectors a lane's checkpoint entries take. Sectors are 32 B. Where entries are 20 B, entry n lies at 20 n, so of
// eight entries (five sectors) numbers 1, 3, 4 and 6 straddle two; of 16 and 8 B none does.
#include "grtx/modules/rt_unit/checkpoint/decide/checkpoint_layout.h"

#include <gtest/gtest.h>

#include <vector>

#include "grtx/base/error.h"
#include "grtx/traces/event.h"

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
  layout.submit(lane, 1);
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
  EXPECT_EQ(layout.close_sector(lane), CheckpointLayout::kNoSector) << "nothing written";
  std::vector<std::uint64_t> open;
  for (unsigned i = 0; i < kEntries; ++i) {
    write(layout, lane);
    CheckpointLayout::Lane ends_here = lane;
    open.push_back(layout.close_sector(ends_here));
    EXPECT_FALSE(layout.has_open_sector(ends_here));
  }
  EXPECT_EQ(open, (std::vector<std::uint64_t>{0, 1, 1, 2, 3, 3, 4, CheckpointLayout::kNoSector}));
  EXPECT_FALSE(layout_of(kFifo, kEntries, false, true).has_open_sector(lane));
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
  header.warp_size = 32;
  header.checkpoint_capacity = kEntries;
  const MemoryMap map(header, {1, 2, 0, 0});
  CheckpointLayout layout = layout_of(kFifo, kEntries, true, true);
  const auto even = layout.begin(map, 0, 0, 5, 2, true, 0, {}), odd = layout.begin(map, 0, 0, 5, 3, true, 0, {});
  EXPECT_EQ(even.destination, odd.source);
  EXPECT_EQ(even.source, odd.destination);
  EXPECT_NE(even.source, even.destination);
}

TEST(CheckpointLayout, ABinBeginsAnewWhenItWasEmptyAndGoesAroundWhenNot) {
  traces::Header header;
  header.checkpoint = true;
  header.checkpoint_bins = 2;
  header.checkpoint_capacity = 6;
  const MemoryMap map(header, {1, 2, 0, 0, 8});
  CheckpointConfig config;
  config.read_buffer = true;
  config.entry_bytes = 8;
  CheckpointLayout layout(config, header);
  traces::Ray ray;
  ray.bins.assign(10, 1);
  ray.rounds.resize(4);
  const std::uint64_t first = map.checkpoint_bin(map.ray_slot(0, 0, 5), 1) / kSectorBytes;
  CheckpointLayout::Lane lane;
  const auto round = [&](std::uint32_t number, unsigned reads, unsigned writes) {
    lane = layout.begin(map, 0, 0, 5, number, number > 0, 0, ray);
    std::vector<std::uint64_t> sectors;
    for (unsigned i = 0; i < reads; ++i) {
      for (const std::uint64_t sector : numbers(layout.read(lane))) sectors.push_back(sector - first);
    }
    for (unsigned i = 0; i < writes; ++i) {
      for (const std::uint64_t sector : numbers(write(layout, lane))) sectors.push_back(sector - first);
    }
    return sectors;
  };
  using Sectors = std::vector<std::uint64_t>;
  EXPECT_EQ(round(0, 0, 3), (Sectors{0, 0, 0}));
  EXPECT_EQ(round(1, 2, 5), (Sectors{0, 0, 1, 1, 0, 0})) << "one is left: places 3, 4, 5, 0, 1";
  EXPECT_EQ(round(2, 6, 0), (Sectors{0, 1, 0})) << "places 2, 3, 4, 5, 0, 1";
  EXPECT_EQ(round(3, 0, 2), (Sectors{0, 0})) << "it was empty: places 0, 1";
  EXPECT_THROW(write(layout, lane), Error) << "no bin is left";
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
