// SPDX-License-Identifier: Apache-2.0
// Tag array of a sectored set-associative cache: one tag per line, valid and dirty bits per sector.
// Plain C++, shared by L1 and L2. Speed depends on how many of the host's cache lines an access touches. A set of up to
// 16 ways is compact, with its LRU order in one word; larger sets use a hash index and an intrusive LRU list.
#pragma once

#include <bit>
#include <cassert>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "grtx/base/state_bytes.h"
#include "grtx/modules/cache/decide/cache_geometry.h"
#include "grtx/modules/cache/decide/replacement.h"
#include "grtx/modules/kernel/address_index.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/equal_keys.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

class SectorCacheTags {
 public:
  using Slot = std::uint32_t;  ///< a line of the cache
  static constexpr Slot kNone = AddressIndex::kNone;
  using Geometry = CacheGeometry;

  /// Contents of a line when insert() evicted it.
  struct Victim {
    bool valid = false;
    std::uint64_t address = 0;  ///< first byte of the line
    std::uint8_t dirty = 0;     ///< sector masks
    std::uint8_t unused_prefetch = 0;
  };

  /// Throws Error if the geometry is impossible (no set, sizes that are no powers of two, more than 8 sectors).
  explicit SectorCacheTags(const Geometry& geometry);

  const Geometry& geometry() const { return geometry_; }
  std::uint8_t sector_bit(std::uint64_t address) const {
    return static_cast<std::uint8_t>(1u << ((address & (geometry_.line_bytes - 1u)) >> sector_shift_));
  }

  /// Upper bound of slot numbers.
  std::size_t slots() const { return static_cast<std::size_t>(set_count_) * stride(); }
  /// Slot of the line that holds `address`, or kNone.
  Slot find(std::uint64_t address) const {
    return large_ ? index_.find(line_number(address)) : find_small(line_number(address));
  }
  /// Prefetches into the host's cache what find(address) reads.
  void prefetch(std::uint64_t address) const {
    if (large_) return index_.prefetch(line_number(address));
    const char* set = reinterpret_cast<const char*>(&small_[set_of(line_number(address))]);
    __builtin_prefetch(set);
    __builtin_prefetch(set + 64);
  }
  // Below, `access` is what a replacement policy is told, with the address as the GPU has it; `address` is the cache's.
  /// The line that insert(address) would replace.
  Victim victim(std::uint64_t address, const MemoryRequest& access) const {
    return victim_in(replaced_by(address, access));
  }
  /// Where insert(address) would put the line.
  Slot victim_slot(std::uint64_t address, const MemoryRequest& access) const { return replaced_by(address, access); }
  /// Inserts the line as most recently used, without valid sectors, in place of the policy's victim (lru: the least
  /// recently used line of the set). The line must not be present.
  Slot insert(std::uint64_t address, const MemoryRequest& access, Victim* evicted) {
    return insert_at(replaced_by(address, access), address, access, evicted);
  }
  /// The clean line to replace if no dirty line can be written back now. lru: the least recently used clean line;
  /// other policies: the first clean line from their victim on, with wrap-around. kNone if all lines are dirty.
  Slot clean_victim(std::uint64_t address, const MemoryRequest& access) const;
  /// Like insert(), into the slot that victim_slot() or clean_victim() returned.
  Slot insert_at(Slot slot, std::uint64_t address, const MemoryRequest& access, Victim* evicted);
  /// Makes the sector valid and its line the most recently used, in place of a clean line; nothing if all are dirty.
  /// Returns what was there.
  Victim preload(std::uint64_t address, const MemoryRequest& access);
  /// Marks the line as most recently used. access(): asked for only where there is a policy.
  template <typename Access>
  void touch(Slot slot, const Access& access) {
    if (policy_ != nullptr) [[unlikely]]
      return policy_->referenced(set_number(slot), way_number(slot), access());
    touch_lru(slot);
  }

  /// Prepares for another launch: empties the tags or keeps all lines. Clears the marks of unused prefetches.
  void restart(bool keep_lines);
  /// Save and restore what restart(true) keeps. load() needs empty tags of the same geometry. save() throws Error if
  /// the replacement policy does not support saving.
  void save(StateWriter& state) const;
  void load(StateReader& state);

  std::uint8_t valid(Slot slot) const { return state(slot).valid; }
  void set_valid(Slot slot, std::uint8_t sectors) { state(slot).valid |= sectors; }
  std::uint8_t dirty(Slot slot) const { return state(slot).dirty; }
  void set_dirty(Slot slot, std::uint8_t sectors) { state(slot).dirty |= sectors; }
  /// Mask of sectors that a prefetch fetched and no demand access has used yet.
  std::uint8_t unused_prefetch(Slot slot) const { return state(slot).unused_prefetch; }
  void set_unused_prefetch(Slot slot, std::uint8_t sectors) { state(slot).unused_prefetch |= sectors; }
  void clear_unused_prefetch(Slot slot, std::uint8_t sectors) {
    state(slot).unused_prefetch &= static_cast<std::uint8_t>(~sectors);
  }
  std::uint64_t lines_valid() const { return lines_valid_; }
  /// Number of unused prefetched sectors in all lines. Linear in the cache size; call at the end of a run.
  std::uint64_t count_unused_prefetch() const;
  /// Number of dirty sectors in all lines. Linear in the cache size.
  std::uint64_t count_dirty() const;
  /// Storage bits for tags, valid, dirty and replacement state, for addresses of `address_bits` bits.
  std::uint64_t tag_bits(unsigned address_bits, bool with_dirty) const;

 private:
  using Way = std::uint16_t;
  static constexpr Way kNoWay = 0xFFFF;

  static constexpr unsigned kSmallWays = 16;
  static constexpr std::uint32_t kNoLine = ~std::uint32_t{0};

  struct State {  // sector masks
    std::uint8_t valid = 0;
    std::uint8_t dirty = 0;
    std::uint8_t unused_prefetch = 0;
  };
  // A set of at most 16 ways. Its slots are set * 16 + way.
  struct alignas(64) SmallSet {
    std::uint64_t order = 0;  ///< way numbers, 4 bits each, most recently used in the lowest bits
    std::uint32_t number[kSmallWays];
    State state[kSmallWays];
  };
  // A line of a larger set. Slots are set * ways + way.
  struct Line {
    std::uint32_t number = kNoLine;  ///< address / line_bytes; kNoLine if empty
    Way newer = kNoWay;              ///< neighbours in the set's recency list
    Way older = kNoWay;
    State state;
  };
  struct Set {
    Way newest = kNoWay;
    Way oldest = kNoWay;
  };

  std::uint64_t line_number(std::uint64_t address) const { return address >> line_shift_; }
  std::uint64_t set_of(std::uint64_t line_number) const {
    return set_mask_ != 0 ? line_number & set_mask_ : line_number % set_count_;
  }
  State& state(Slot slot) { return large_ ? lines_[slot].state : small_[slot / kSmallWays].state[slot % kSmallWays]; }
  const State& state(Slot slot) const {
    return large_ ? lines_[slot].state : small_[slot / kSmallWays].state[slot % kSmallWays];
  }
  std::uint32_t& number(Slot slot) {
    return large_ ? lines_[slot].number : small_[slot / kSmallWays].number[slot % kSmallWays];
  }
  std::uint32_t number(Slot slot) const {
    return large_ ? lines_[slot].number : small_[slot / kSmallWays].number[slot % kSmallWays];
  }
  Slot find_small(std::uint64_t number) const {
    const std::uint64_t set = set_of(number);
    const SmallSet& s = small_[set];
    const unsigned hit = equal_keys(s.number, static_cast<std::uint32_t>(number));
    return hit == 0 ? kNone : static_cast<Slot>(set * kSmallWays + static_cast<unsigned>(std::countr_zero(hit)));
  }
  [[gnu::always_inline]] void touch_lru(Slot slot) {
    if (large_) {
      if (lines_[slot].newer != kNoWay) touch_large(slot);  // otherwise it is already the newest
      return;
    }
    touch_small(small_[slot / kSmallWays], slot % kSmallWays);
  }
  static void touch_small(SmallSet& set, unsigned way) {
    // Finds the lowest nibble equal to `way`: the lowest zero nibble of the XOR, by the borrow trick.
    constexpr std::uint64_t kOnes = 0x1111111111111111u;
    const std::uint64_t differs = set.order ^ (kOnes * way);
    const auto position = static_cast<unsigned>(std::countr_zero((differs - kOnes) & ~differs & (kOnes << 3))) & ~3u;
    const std::uint64_t newer = (std::uint64_t{1} << position) - 1;
    set.order = (set.order & ~(newer << 4 | 0xF)) | (set.order & newer) << 4 | way;
  }
  void touch_large(Slot slot);
  Victim victim_in(Slot slot) const;
  std::vector<unsigned> newest_first(std::uint64_t set) const;
  void order(std::uint64_t set, const std::vector<unsigned>& newest_first);
  template <typename F>
  void for_each_state(F&& f) const {
    for (const SmallSet& set : small_) {
      for (const State& s : set.state) f(s);
    }
    for (const Line& line : lines_) f(line.state);
  }
  unsigned stride() const { return large_ ? geometry_.ways : kSmallWays; }  ///< slots per set
  std::uint64_t set_number(Slot slot) const { return slot / stride(); }
  unsigned way_number(Slot slot) const { return static_cast<unsigned>(slot % stride()); }
  Slot replaced_by(std::uint64_t address, const MemoryRequest& access) const {
    return policy_ == nullptr ? oldest_of(address) : chosen_by_policy(address, access);
  }
  Slot chosen_by_policy(std::uint64_t address, const MemoryRequest& access) const;
  Slot oldest_of(std::uint64_t address) const {
    const std::uint64_t set = set_of(line_number(address));
    if (large_) return static_cast<Slot>(set * geometry_.ways + sets_[set].oldest);
    return static_cast<Slot>(set * kSmallWays + (small_[set].order >> 4 * (geometry_.ways - 1) & 0xF));
  }

  Geometry geometry_;
  bool large_;  ///< more than 16 ways
  std::uint64_t set_count_;
  std::vector<SmallSet> small_;  ///< up to 16 ways; larger sets use the next three members instead
  std::vector<Line> lines_;
  std::vector<Set> sets_;
  AddressIndex index_;
  unsigned line_shift_;
  unsigned sector_shift_;
  unsigned way_shift_;      ///< log2(ways) if a power of two, else 0
  std::uint64_t set_mask_;  ///< sets - 1 if a power of two, else 0
  std::uint64_t lines_valid_ = 0;
  std::unique_ptr<CacheReplacement> policy_;  ///< null for lru, which uses the recency orders above
  std::vector<unsigned> filled_;              ///< [set], only with a policy: number of ways that hold a line
};

}  // namespace grtx::modules
