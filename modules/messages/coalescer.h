// SPDX-License-Identifier: Apache-2.0
// Merges the addresses of one warp memory instruction into distinct 32 B sectors, in order of first touch (lane order).
// Only lanes of the same instruction merge; two instructions that touch the same sector request it twice.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

/// One request for the sector that starts at `address` (a multiple of kSectorBytes).
struct SectorAccess {
  std::uint64_t address = 0;
  Region region = Region::ray;
  friend bool operator==(const SectorAccess&, const SectorAccess&) = default;
};

class Coalescer {
 public:
  /// most_sectors: most distinct sectors that one instruction can touch.
  explicit Coalescer(std::size_t most_sectors)
      : table_(std::bit_ceil(2 * (most_sectors + 1))), shift_(64 - std::countr_zero(table_.size())) {}

  /// Starts a warp memory instruction whose sectors are appended to `out`.
  void begin(Region region, std::vector<SectorAccess>& out) {
    region_ = region;
    out_ = &out;
    ++instruction_;
    last_ = ~std::uint64_t{0};
  }

  /// A lane touches bytes [address, address + bytes).
  void touch(std::uint64_t address, std::uint64_t bytes) {
    const std::uint64_t end = (address + bytes - 1) / kSectorBytes;
    for (std::uint64_t sector = address / kSectorBytes; sector <= end; ++sector) {
      if (sector != last_) add(sector);  // fast path: a lane often touches the previous lane's sector
    }
  }

 private:
  struct Seen {
    std::uint64_t sector = 0;
    std::uint64_t instruction = 0;
  };

  void add(std::uint64_t sector) {
    last_ = sector;
    const std::size_t mask = table_.size() - 1;
    std::size_t i = static_cast<std::size_t>((sector * 0x9E3779B97F4A7C15ULL) >> shift_) & mask;  // Fibonacci hashing
    while (table_[i].instruction == instruction_) {
      if (table_[i].sector == sector) return;
      i = (i + 1) & mask;
    }
    table_[i] = {sector, instruction_};
    out_->push_back({.address = sector * kSectorBytes, .region = region_});
  }

  std::vector<Seen> table_;  ///< open addressing; entries of earlier instructions count as empty
  int shift_;
  std::uint64_t instruction_ = 0;
  std::uint64_t last_ = 0;
  Region region_ = Region::ray;
  std::vector<SectorAccess>* out_ = nullptr;
};

}  // namespace grtx::modules
