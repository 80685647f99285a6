// Tag array of a sectored set-associative cache with LRU replacement: one tag a line, valid and dirty bits a sector.
// Plain C++, shared by L1 and L2. 256-way sets are affordable: lookup is one hash probe, LRU an intrusive list.
#pragma once

#include <cstdint>
#include <vector>

#include "modules/address_index.h"

namespace grtx::modules {

class SectorCacheTags {
 public:
  using Slot = std::uint32_t;  ///< set * ways + way
  static constexpr Slot kNone = AddressIndex::kNone;

  struct Geometry {
    std::uint64_t bytes = 128 * 1024;
    unsigned line_bytes = 128;
    unsigned sector_bytes = 32;
    unsigned ways = 256;
    std::uint64_t sets() const { return bytes / (std::uint64_t{line_bytes} * ways); }  ///< rounded down, any number
    unsigned sectors() const { return line_bytes / sector_bytes; }                     ///< of a line, at most 8
  };

  /// What a line held when insert() evicted it.
  struct Victim {
    bool valid = false;
    std::uint64_t address = 0;  ///< first byte of the line
    std::uint8_t dirty = 0;     ///< sector masks
    std::uint8_t unused_prefetch = 0;
  };

  /// Throws Error when the geometry gives no set, or sizes are not multiples of each other.
  explicit SectorCacheTags(const Geometry& geometry);

  const Geometry& geometry() const { return geometry_; }
  std::uint64_t line_address(std::uint64_t address) const {
    return address & ~std::uint64_t{geometry_.line_bytes - 1u};
  }
  std::uint8_t sector_bit(std::uint64_t address) const {
    return static_cast<std::uint8_t>(1u << ((address & (geometry_.line_bytes - 1u)) >> sector_shift_));
  }

  /// Slot of the line that holds `address`, or kNone.
  Slot find(std::uint64_t address) const { return index_.find(line_number(address)); }
  /// The line that insert(address) would replace.
  Victim victim(std::uint64_t address) const;
  /// Makes the line present with no valid sector and most recently used; the least recently used line of the set goes.
  /// The line must not be present.
  Slot insert(std::uint64_t address, Victim* evicted);
  /// Marks the line as most recently used.
  void touch(Slot slot);

  std::uint8_t valid(Slot slot) const { return lines_[slot].valid; }
  void set_valid(Slot slot, std::uint8_t sectors) { lines_[slot].valid |= sectors; }
  std::uint8_t dirty(Slot slot) const { return lines_[slot].dirty; }
  void set_dirty(Slot slot, std::uint8_t sectors) { lines_[slot].dirty |= sectors; }
  /// Sectors that a prefetch brought in and no demand access has referenced yet.
  std::uint8_t unused_prefetch(Slot slot) const { return lines_[slot].unused_prefetch; }
  void set_unused_prefetch(Slot slot, std::uint8_t sectors) { lines_[slot].unused_prefetch |= sectors; }
  void clear_unused_prefetch(Slot slot, std::uint8_t sectors) {
    lines_[slot].unused_prefetch &= static_cast<std::uint8_t>(~sectors);
  }
  std::uint64_t lines_valid() const { return lines_valid_; }
  /// Sectors with the mark of an unreferenced prefetch, over all lines. Linear: for the end of a run.
  std::uint64_t count_unused_prefetch() const;
  /// Dirty sectors over all lines. Linear: for the end of a run.
  std::uint64_t count_dirty() const;
  /// Bits of tag, valid, dirty and true-LRU state for addresses of `address_bits` bits.
  std::uint64_t tag_bits(unsigned address_bits, bool with_dirty) const;

 private:
  using Way = std::uint16_t;
  static constexpr Way kNoWay = 0xFFFF;

  struct Line {                // 16 B: four to a line of the host's cache
    std::uint32_t number = 0;  ///< address / line_bytes, when present
    Way newer = kNoWay;        ///< neighbours in the set's recency list
    Way older = kNoWay;
    bool present = false;
    std::uint8_t valid = 0;
    std::uint8_t dirty = 0;
    std::uint8_t unused_prefetch = 0;
    std::uint32_t set = 0;
  };
  struct Set {
    Way newest = kNoWay;
    Way oldest = kNoWay;
  };

  std::uint64_t line_number(std::uint64_t address) const { return address >> line_shift_; }
  std::uint64_t set_of(std::uint64_t line_number) const {
    return set_mask_ != 0 ? line_number & set_mask_ : line_number % sets_.size();
  }
  Slot oldest_of(std::uint64_t address) const {
    const std::uint64_t set = set_of(line_number(address));
    return static_cast<Slot>(set * geometry_.ways + sets_[set].oldest);
  }

  Geometry geometry_;
  std::vector<Line> lines_;
  std::vector<Set> sets_;
  AddressIndex index_;
  unsigned line_shift_;
  unsigned sector_shift_;
  std::uint64_t set_mask_;  ///< sets - 1 for a power of two of sets, else 0
  std::uint64_t lines_valid_ = 0;
};

}  // namespace grtx::modules
