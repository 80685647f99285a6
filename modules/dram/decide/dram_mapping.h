// SPDX-License-Identifier: Apache-2.0
// Maps a channel-local address to its bank and row. Free of SystemC.
#pragma once

#include <bit>
#include <cstdint>

#include "grtx/modules/dram/decide/dram_config.h"

namespace grtx::modules {

class DramMapping {
 public:
  struct Place {
    std::uint64_t row;
    std::uint32_t bank;  ///< bank group = bank mod bank_groups
  };

  explicit DramMapping(const DramChannelConfig& config)
      : groups_(config.bank_groups),
        block_(config.group_bytes),
        row_bytes_(config.row_bytes),
        banks_of_group_(config.banks / config.bank_groups),
        fold_(config.bank_xor ? config.banks - 1 : 0) {}

  /// local: channel-local byte address.
  Place place(std::uint64_t local) const {
    std::uint64_t group = 0;
    if (groups_.value > 1) {
      const std::uint64_t block = block_.quotient(local);
      const std::uint64_t block_of_group = groups_.quotient(block);
      group = block - block_of_group * groups_.value;
      local -= (block - block_of_group) * block_.value;  // now relative to the group
    }
    const std::uint64_t number = row_bytes_.quotient(local);
    const std::uint64_t row = banks_of_group_.quotient(number);
    const std::uint64_t bank = (number - row * banks_of_group_.value) * groups_.value + group;
    return {row, static_cast<std::uint32_t>(bank ^ (row & fold_))};
  }
  unsigned group(std::uint32_t bank) const { return bank % groups_.value; }

 private:
  /// Shifts if the divisor is a power of two: a real division takes as long as the rest of enqueue().
  struct Divisor {
    explicit Divisor(unsigned divisor)
        : value(divisor), shift(std::has_single_bit(divisor) ? std::countr_zero(divisor) : -1) {}
    std::uint64_t quotient(std::uint64_t dividend) const { return shift >= 0 ? dividend >> shift : dividend / value; }
    unsigned value;
    int shift;
  };

  Divisor groups_, block_, row_bytes_, banks_of_group_;
  std::uint64_t fold_;  ///< mask of the row bits that are XORed into the bank number
};

}  // namespace grtx::modules
