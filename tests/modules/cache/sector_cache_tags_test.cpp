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
        const SectorCacheTags::Victim foreseen = tags.victim(address);
        slot = tags.insert(address, &victim);
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
        tags.touch(slot);
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
  EXPECT_EQ(tags.tag_bits(40, true), 1024u * (31 + 1 + 4 + 4 + 8));  // a dirty bit a sector
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

}  // namespace
}  // namespace grtx::modules
