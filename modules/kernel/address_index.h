// SPDX-License-Identifier: Apache-2.0
// Hash map from a line or sector number to an index: open addressing, fixed capacity. A lookup in a 256-way set costs
// one probe instead of 256 comparisons. Key and value share an 8-byte entry, so a probe touches one cache line of the
// host. The map stands for the parallel comparators of a tag array or MSHR file and has no timing of its own.
#pragma once

#include <bit>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace grtx::modules {

class AddressIndex {
 public:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  /// max_entries: most keys held at a time; the table is at most half full. Keys must be below 2^32 - 1, which covers
  /// 512 GB in 128 B lines or 128 GB in 32 B sectors.
  explicit AddressIndex(std::size_t max_entries)
      : entries_(std::bit_ceil(2 * max_entries)),
        mask_(entries_.size() - 1),
        shift_(64u - static_cast<unsigned>(std::countr_zero(entries_.size()))) {}

  std::uint32_t find(std::uint64_t key) const {
    for (std::size_t i = home(key);; i = next(i)) {
      if (entries_[i].key == key) return entries_[i].value;
      if (entries_[i].key == kEmpty) return kNone;
    }
  }
  /// Prefetches into the host's cache the entry that find(key) probes first.
  void prefetch(std::uint64_t key) const { __builtin_prefetch(&entries_[home(key)]); }
  /// The key must not be present.
  void insert(std::uint64_t key, std::uint32_t value) {
    assert(key < kEmpty);
    std::size_t i = home(key);
    while (entries_[i].key != kEmpty) {
      assert(entries_[i].key != key);
      i = next(i);
    }
    entries_[i] = {static_cast<std::uint32_t>(key), value};
  }
  /// The key must be present. Later keys of the probe sequence are shifted back, so no tombstones are needed.
  void erase(std::uint64_t key) {
    std::size_t hole = home(key);
    while (entries_[hole].key != key) {
      assert(entries_[hole].key != kEmpty);
      hole = next(hole);
    }
    for (std::size_t i = next(hole); entries_[i].key != kEmpty; i = next(i)) {
      const std::size_t distance_to_home = (i - home(entries_[i].key)) & mask_;
      const std::size_t distance_to_hole = (i - hole) & mask_;
      if (distance_to_home < distance_to_hole) continue;
      entries_[hole] = entries_[i];
      hole = i;
    }
    entries_[hole].key = kEmpty;
  }

 private:
  static constexpr std::uint32_t kEmpty = ~std::uint32_t{0};

  struct Entry {
    std::uint32_t key = kEmpty;
    std::uint32_t value = kNone;
  };

  std::size_t home(std::uint64_t key) const {  // Fibonacci hashing: multiplication by 2^64 / golden ratio
    return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15u) >> shift_);
  }
  std::size_t next(std::size_t i) const { return (i + 1) & mask_; }

  std::vector<Entry> entries_;
  std::size_t mask_;
  unsigned shift_;
};

}  // namespace grtx::modules
