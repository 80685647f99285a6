// SPDX-License-Identifier: Apache-2.0
// SectorCacheTags and AddressIndex against plain reference models, with random operations.
#include "grtx/modules/cache/decide/sector_cache_tags.h"

#include <gtest/gtest.h>

#include <list>
#include <map>

#include "grtx/base/error.h"
#include "modules/memory_mocks.h"

namespace grtx::modules {
namespace {

TEST(AddressIndexTest, AgreesWithAMap) {
  AddressIndex index(100);
  std::map<std::uint64_t, std::uint32_t> reference;
  Random random(1);
  for (int i = 0; i < 200000; ++i) {
    const std::uint64_t key = random.below(150) * (random.chance(50) ? 1u : 0x10001u);
    const auto found = reference.find(key);
    ASSERT_EQ(index.find(key), found == reference.end() ? AddressIndex::kNone : found->second);
    if (found != reference.end()) {
      index.erase(key);
      reference.erase(found);
    } else if (reference.size() < 100) {
      index.insert(key, static_cast<std::uint32_t>(i));
      reference[key] = static_cast<std::uint32_t>(i);
    }
  }
}

TEST(SectorCacheTagsTest, AgreesWithLruLists) {
  struct Case {
    std::uint64_t bytes;
    unsigned ways;
  };
  for (const Case c : {Case{2048, 4}, Case{2048, 16}, Case{128 * 7, 1}, Case{128 * 3 * 5, 5}}) {
    SectorCacheTags tags({c.bytes, 128, 32, c.ways});
    const std::uint64_t sets = c.bytes / 128 / c.ways;
    struct Line {
      std::uint64_t number;
      std::uint8_t valid, dirty;
    };
    std::vector<std::list<Line>> reference(sets);  // newest first
    Random random(c.ways);
    for (int i = 0; i < 20000; ++i) {
      const std::uint64_t address = random.below(c.bytes / 32 * 2) * 32;
      const std::uint8_t sector = static_cast<std::uint8_t>(1u << (address / 32 % 4));
      std::list<Line>& set = reference[address / 128 % sets];
      const auto line = std::find_if(set.begin(), set.end(), [&](const Line& l) { return l.number == address / 128; });
      SectorCacheTags::Slot slot = tags.find(address);
      ASSERT_EQ(slot == SectorCacheTags::kNone, line == set.end());
      if (line == set.end()) {
        SectorCacheTags::Victim victim;
        const SectorCacheTags::Victim foreseen = tags.victim(address, {});
        slot = tags.insert(address, {}, &victim);
        ASSERT_EQ(victim.valid, set.size() == c.ways);
        ASSERT_EQ(foreseen.valid, victim.valid);
        if (victim.valid) {
          ASSERT_EQ(victim.address, set.back().number * 128);
          ASSERT_EQ(foreseen.address, victim.address);
          ASSERT_EQ(victim.dirty, set.back().dirty);
          set.pop_back();
        }
        set.push_front({address / 128, 0, 0});
      } else {
        ASSERT_EQ(tags.valid(slot), line->valid);
        ASSERT_EQ(tags.dirty(slot), line->dirty);
        tags.touch(slot, [] { return MemoryRequest(); });
        set.splice(set.begin(), set, line);
      }
      tags.set_valid(slot, sector);
      set.front().valid |= sector;
      if (random.chance(30)) {
        tags.set_dirty(slot, sector);
        set.front().dirty |= sector;
      }
    }
  }
}

TEST(SectorCacheTagsTest, StorageOfThePapersL1) {
  const SectorCacheTags tags({});
  EXPECT_EQ(tags.geometry().sets(), 4u);
  // 40-bit addresses: 40 - 7 (offset) - 2 (set) tag bits, presence, 4 sector bits, 8 bits of recency.
  EXPECT_EQ(tags.tag_bits(40, false), 1024u * (31 + 1 + 4 + 8));
  EXPECT_EQ(tags.tag_bits(40, true), 1024u * (31 + 1 + 4 + 4 + 8));  // a dirty bit per sector
  EXPECT_EQ(SectorCacheTags({256, 128, 32, 2}).tag_bits(40, false), 2u * (33 + 1 + 4 + 1));
}

TEST(SectorCacheTagsTest, ImpossibleGeometriesAreRefused) {
  EXPECT_THROW(SectorCacheTags({1024, 128, 32, 16}), Error);
  EXPECT_THROW(SectorCacheTags({1024, 96, 32, 1}), Error);
  EXPECT_THROW(SectorCacheTags({1024, 128, 48, 1}), Error);
  EXPECT_THROW(SectorCacheTags({4096, 512, 32, 1}), Error);
  EXPECT_NO_THROW(SectorCacheTags({4096, 256, 32, 1}));  // 8 sectors
  EXPECT_NO_THROW(SectorCacheTags({65534 * 32, 32, 32, 65534}));
  EXPECT_THROW(SectorCacheTags({65535 * 32, 32, 32, 65535}), Error);
}

// Every policy, small and large sets: what was loaded hits and evicts as what was saved.
TEST(SectorCacheTagsTest, LoadedTagsDoWhatTheSavedOnesWouldHave) {
  for (const char* replacement : {"lru", "fifo", "random"}) {
    for (const unsigned ways : {1u, 3u, 16u, 24u}) {
      const SectorCacheTags::Geometry geometry{std::uint64_t{128} * ways * 5, 128, 32, ways, replacement};
      SectorCacheTags tags(geometry), loaded(geometry);
      Random random(ways);
      const auto access = [&](SectorCacheTags& cache, std::uint64_t address, bool dirty,
                              SectorCacheTags::Victim& victim) {
        SectorCacheTags::Slot slot = cache.find(address);
        if (slot == SectorCacheTags::kNone) slot = cache.insert(address, {}, &victim);
        cache.touch(slot, [] { return MemoryRequest(); });
        cache.set_valid(slot, cache.sector_bit(address));
        if (dirty) cache.set_dirty(slot, cache.sector_bit(address));
      };
      SectorCacheTags::Victim victim, of_loaded;
      for (unsigned i = 0; i < ways * 9; ++i) {  // not all sets are full
        access(tags, random.below(ways * 12) * 128 + random.below(4) * 32, random.chance(30), victim);
      }
      StateWriter out;
      tags.save(out);
      StateReader in("state", out.bytes());
      loaded.load(in);
      in.require_end();
      EXPECT_EQ(loaded.lines_valid(), tags.lines_valid());
      EXPECT_EQ(loaded.count_dirty(), tags.count_dirty());
      for (int i = 0; i < 5000; ++i) {
        const std::uint64_t address = random.below(ways * 12) * 128 + random.below(4) * 32;
        const bool dirty = random.chance(30);
        victim = of_loaded = {};
        access(tags, address, dirty, victim);
        access(loaded, address, dirty, of_loaded);
        ASSERT_EQ(victim.valid, of_loaded.valid);
        ASSERT_EQ(victim.address, of_loaded.address) << replacement << ways;
        ASSERT_EQ(victim.dirty, of_loaded.dirty);
      }
    }
  }
}

TEST(SectorCacheTagsTest, LoadRefusesWhatNoTagsHaveSaved) {
  const SectorCacheTags::Geometry small{128 * 4 * 2, 128, 32, 4}, large{128 * 20 * 2, 128, 32, 20};
  for (const SectorCacheTags::Geometry& geometry : {small, large}) {
    SectorCacheTags tags(geometry);
    SectorCacheTags::Victim victim;
    for (std::uint64_t line = 0; line < geometry.ways; ++line) tags.insert(line * 128, {}, &victim);
    StateWriter out;
    tags.save(out);
    unsigned refused = 0;
    for (std::size_t at = 0; at < out.bytes().size(); ++at) {
      std::string damaged = out.bytes();
      damaged[at] = static_cast<char>(damaged[at] ^ 1);
      SectorCacheTags loaded(geometry);
      StateReader in("state", damaged);
      try {
        loaded.load(in);
      } catch (const Error&) {
        ++refused;
        continue;
      }
      for (std::uint64_t line = 0; line < 3 * geometry.ways; ++line) {  // it is some state of such a cache
        if (loaded.find(line * 128) == SectorCacheTags::kNone) loaded.insert(line * 128, {}, &victim);
      }
      EXPECT_EQ(loaded.lines_valid(), geometry.bytes / 128);
    }
    EXPECT_GT(refused, 0u);
  }
}

}  // namespace
}  // namespace grtx::modules
