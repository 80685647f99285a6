// Finds a small number by a 64-bit key: open addressing of fixed capacity, so a 256-way set costs one probe, not 256.
// It stands for the parallel comparators of a tag array or MSHR file; it has no timing of its own.
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

  /// max_entries: keys held at a time; the table is kept at most half full. The key ~0 is reserved.
  explicit AddressIndex(std::size_t max_entries)
      : keys_(std::bit_ceil(2 * max_entries + 2), kEmpty),
        values_(keys_.size(), kNone),
        shift_(64u - static_cast<unsigned>(std::countr_zero(keys_.size()))) {}

  std::uint32_t find(std::uint64_t key) const {
    for (std::size_t i = home(key);; i = next(i)) {
      if (keys_[i] == key) return values_[i];
      if (keys_[i] == kEmpty) return kNone;
    }
  }
  /// The key must not be present.
  void insert(std::uint64_t key, std::uint32_t value) {
    assert(key != kEmpty);
    std::size_t i = home(key);
    while (keys_[i] != kEmpty) {
      assert(keys_[i] != key);
      i = next(i);
    }
    keys_[i] = key;
    values_[i] = value;
  }
  /// The key must be present. Later keys of the probe sequence move up, so no tombstones pile up.
  void erase(std::uint64_t key) {
    std::size_t hole = home(key);
    while (keys_[hole] != key) {
      assert(keys_[hole] != kEmpty);
      hole = next(hole);
    }
    for (std::size_t i = next(hole); keys_[i] != kEmpty; i = next(i)) {
      const std::size_t distance_to_home = (i - home(keys_[i])) & (keys_.size() - 1);
      const std::size_t distance_to_hole = (i - hole) & (keys_.size() - 1);
      if (distance_to_home < distance_to_hole) continue;
      keys_[hole] = keys_[i];
      values_[hole] = values_[i];
      hole = i;
    }
    keys_[hole] = kEmpty;
  }

 private:
  static constexpr std::uint64_t kEmpty = ~std::uint64_t{0};

  std::size_t home(std::uint64_t key) const {  // Fibonacci hashing: multiplication by 2^64 / golden ratio
    return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15u) >> shift_);
  }
  std::size_t next(std::size_t i) const { return (i + 1) & (keys_.size() - 1); }

  std::vector<std::uint64_t> keys_;
  std::vector<std::uint32_t> values_;
  unsigned shift_;
};

}  // namespace grtx::modules
