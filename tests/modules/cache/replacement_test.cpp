// SPDX-License-Identifier: Apache-2.0
// Cache replacement policies: the victim that each names, in tags of few and of many ways.
#include "grtx/modules/cache/decide/replacement.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/modules/cache/decide/sector_cache_tags.h"
#include "grtx/modules/kernel/wrong_answer.h"

namespace grtx::modules {
namespace {

/// The lines that go, by number, when these lines are read one after the other in a cache of one set.
std::vector<std::uint64_t> evicted(const std::string& policy, unsigned ways, const std::vector<std::uint64_t>& lines) {
  SectorCacheTags tags({std::uint64_t{128} * ways, 128, 32, ways, policy});
  std::vector<std::uint64_t> gone;
  for (const std::uint64_t line : lines) {
    if (const auto slot = tags.find(line * 128); slot != SectorCacheTags::kNone) {
      tags.touch(slot, [] { return MemoryRequest(); });
      continue;
    }
    const SectorCacheTags::Victim foretold = tags.victim(line * 128, {});
    SectorCacheTags::Victim victim;
    tags.insert(line * 128, {}, &victim);
    EXPECT_EQ(foretold.valid, victim.valid);
    EXPECT_EQ(foretold.address, victim.address);
    if (victim.valid) gone.push_back(victim.address / 128);
  }
  return gone;
}

using Lines = std::vector<std::uint64_t>;

TEST(CacheReplacement, LruKeepsWhatWasHitFifoDoesNot) {
  EXPECT_EQ(evicted("lru", 3, {1, 2, 3, 1, 4, 5}), (Lines{2, 3}));
  EXPECT_EQ(evicted("fifo", 3, {1, 2, 3, 1, 4, 5}), (Lines{1, 2}));
}

TEST(CacheReplacement, FifoInSetsOfManyWays) {
  Lines lines;
  for (std::uint64_t i = 0; i < 60; ++i) lines.push_back(i);
  Lines first;
  for (std::uint64_t i = 0; i < 20; ++i) first.push_back(i);
  EXPECT_EQ(evicted("fifo", 40, lines), first);
}

TEST(CacheReplacement, RandomEvictsLinesOfTheSetOnlyAndAlwaysTheSame) {
  Lines lines;
  for (std::uint64_t i = 0; i < 200; ++i) lines.push_back(i * 7 % 50);
  const Lines gone = evicted("random", 8, lines);
  EXPECT_EQ(gone, evicted("random", 8, lines));
  EXPECT_GT(gone.size(), 100U);
  EXPECT_NE(gone, evicted("fifo", 8, lines));
}

/// The lines that go from one full set of `ways`, where those below `dirty` are dirty and have no way out.
std::vector<std::uint64_t> evicted_clean(const std::string& policy, unsigned ways, unsigned dirty, unsigned fills) {
  SectorCacheTags tags({std::uint64_t{128} * ways, 128, 32, ways, policy});
  SectorCacheTags::Victim victim;
  for (std::uint64_t line = 0; line < ways; ++line) {
    const auto slot = tags.insert(line * 128, {}, &victim);
    if (line < dirty) tags.set_dirty(slot, 1);
  }
  std::vector<std::uint64_t> gone;
  for (std::uint64_t line = ways; line < ways + fills; ++line) {
    const auto slot = tags.clean_victim(line * 128, {});
    if (slot == SectorCacheTags::kNone) break;
    EXPECT_EQ(tags.insert_at(slot, line * 128, {}, &victim), slot);
    EXPECT_EQ(victim.dirty, 0);
    EXPECT_EQ(tags.find(line * 128), slot);
    gone.push_back(victim.address / 128);
  }
  for (std::uint64_t line = 0; line < dirty; ++line) EXPECT_NE(tags.find(line * 128), SectorCacheTags::kNone);
  return gone;
}

TEST(CacheReplacement, DirtyLinesWithoutAWayOutArePassedOver) {
  for (const std::string policy : {"lru", "fifo"}) {
    EXPECT_EQ(evicted_clean(policy, 4, 2, 3), (Lines{2, 3, 4})) << policy;
    Lines clean;
    for (std::uint64_t i = 15; i < 75; ++i) clean.push_back(i);
    EXPECT_EQ(evicted_clean(policy, 40, 15, 60), clean) << policy;
  }
  EXPECT_EQ(evicted_clean("random", 8, 3, 50).size(), 50U);
  for (const std::string policy : {"lru", "fifo", "random"}) {
    EXPECT_EQ(evicted_clean(policy, 4, 4, 1), Lines{}) << policy;
    EXPECT_EQ(evicted_clean(policy, 40, 40, 1), Lines{}) << policy;
  }
}

/// Most recently used goes first: made here, known by its name from then on.
class MostRecent final : public CacheReplacement {
 public:
  explicit MostRecent(std::uint64_t sets) : last_(sets) {}
  void filled(std::uint64_t set, unsigned way, const MemoryRequest&) override { last_[set] = way; }
  void referenced(std::uint64_t set, unsigned way, const MemoryRequest&) override { last_[set] = way; }
  unsigned victim(std::uint64_t set, const MemoryRequest&) const override { return last_[set]; }
  unsigned bits_per_line() const override { return 1; }

 private:
  std::vector<unsigned> last_;
};

TEST(CacheReplacement, OneOfTheUsersIsRegisteredByName) {
  register_cache_replacement("most_recent",
                             [](std::uint64_t sets, unsigned) { return std::make_unique<MostRecent>(sets); });
  EXPECT_EQ(evicted("most_recent", 3, {1, 2, 3, 1, 4, 5}), (Lines{1, 4}));
  EXPECT_EQ(cache_replacement_names().back(), "most_recent");
  StateWriter state;
  EXPECT_THROW(SectorCacheTags({1024, 128, 32, 2, "most_recent"}).save(state), Error);  // it does not say what it keeps
  EXPECT_THROW(register_cache_replacement("most_recent", {}), std::logic_error);
}

/// Remembers what it was told.
struct Listener final : CacheReplacement {
  static std::vector<MemoryRequest>& heard() {
    static std::vector<MemoryRequest> all;
    return all;
  }
  void filled(std::uint64_t, unsigned, const MemoryRequest& access) override { heard().push_back(access); }
  void referenced(std::uint64_t, unsigned, const MemoryRequest& access) override { heard().push_back(access); }
  unsigned victim(std::uint64_t, const MemoryRequest& access) const override {
    heard().push_back(access);
    return 0;
  }
  unsigned bits_per_line() const override { return 0; }
};

TEST(CacheReplacement, APolicyHeardOfSetsAndWaysOnly) {
  register_cache_replacement("listener", [](std::uint64_t, unsigned) { return std::make_unique<Listener>(); });
  SectorCacheTags tags({128, 128, 32, 1, "listener"});
  SectorCacheTags::Victim victim;
  const MemoryRequest first{.address = 0x1000, .client = 3, .sm = 2, .region = Region::instance};
  const MemoryRequest second{.address = 0x2020, .client = 1, .sm = 5, .region = Region::k_buffer, .write = true};
  tags.touch(tags.insert(0, first, &victim), [&] { return second; });
  tags.insert(128, second, &victim);
  ASSERT_EQ(Listener::heard().size(), 4u);
  for (const auto& [i, wanted] : {std::pair(0, first), {1, second}, {2, second}, {3, second}}) {
    const MemoryRequest& heard = Listener::heard()[static_cast<std::size_t>(i)];
    EXPECT_EQ(heard.address, wanted.address) << i;
    EXPECT_EQ(heard.region, wanted.region) << i;
    EXPECT_EQ(heard.sm, wanted.sm) << i;
    EXPECT_EQ(heard.client, wanted.client) << i;
    EXPECT_EQ(heard.write, wanted.write) << i;
  }
}

/// Names a way that no cache has.
class Nonsense final : public CacheReplacement {
 public:
  void filled(std::uint64_t, unsigned, const MemoryRequest&) override {}
  void referenced(std::uint64_t, unsigned, const MemoryRequest&) override {}
  unsigned victim(std::uint64_t, const MemoryRequest&) const override { return 4711; }
  unsigned bits_per_line() const override { return 0; }
};

TEST(CacheReplacement, AWayThatTheSetHasNotIsBlamedOnThePolicy) {
  register_cache_replacement("nonsense", [](std::uint64_t, unsigned) { return std::make_unique<Nonsense>(); });
  for (const unsigned ways : {3u, 40u}) {
    Lines lines;
    for (std::uint64_t i = 0; i <= ways; ++i) lines.push_back(i);
    EXPECT_THAT([&] { evicted("nonsense", ways, lines); },
                ::testing::ThrowsMessage<WrongAnswer>("the cache replacement nonsense chose way 4711 of " +
                                                      std::to_string(ways)));
  }
}

TEST(CacheReplacement, AFactoryThatMakesNothingIsNamed) {
  register_cache_replacement("nothing", [](std::uint64_t, unsigned) { return nullptr; });
  EXPECT_THAT([] { evicted("nothing", 3, {1}); }, ::testing::ThrowsMessage<Error>(::testing::HasSubstr(
                                                      "the factory of the cache replacement nothing made nothing")));
}

TEST(CacheReplacement, AnUnknownNameIsAnErrorThatListsTheKnownOnes) {
  EXPECT_THAT(
      [&] {
        SectorCacheTags({1024, 128, 32, 4, "clock"});
      },
      ::testing::ThrowsMessage<Error>(::testing::HasSubstr("lru, fifo, random")));
}

}  // namespace
}  // namespace grtx::modules
