// The banks of a cache in fast mode: each serves one sector a cycle. Cycles need not be asked for in the order of time.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "base/strong.h"

namespace grtx::tlm {

class BankCalendar {
 public:
  static constexpr Cycle kWindow = 4096;  ///< cycles that are kept; later ones are given to whoever asks

  /// banks: 1 to 64.
  explicit BankCalendar(unsigned banks)
      : banks_(banks), mask_(std::has_single_bit(banks) ? banks - 1 : 0), busy_(kWindow) {}

  /// Number of the bank that holds a sector.
  unsigned bank(std::uint64_t sector) const {
    return static_cast<unsigned>(mask_ != 0 || banks_ == 1 ? sector & mask_ : sector % banks_);
  }
  /// The first cycle from `from` on in which the bank is free; it is taken. Past cycles are not given.
  Cycle reserve(unsigned bank, Cycle from) {
    const std::uint64_t bit = std::uint64_t{1} << bank;
    for (from = std::max(from, base_); from < base_ + kWindow; ++from) {
      std::uint64_t& busy = busy_[from % kWindow];
      if ((busy & bit) != 0) continue;
      busy |= bit;
      break;
    }
    return from;
  }
  /// Cycles before `now` are past.
  void advance(Cycle now) {
    for (; base_ < now; ++base_) busy_[base_ % kWindow] = 0;
  }

 private:
  unsigned banks_;
  unsigned mask_;  ///< banks - 1 for a power of two of banks, else 0
  Cycle base_ = 0;
  std::vector<std::uint64_t> busy_;  ///< by cycle: a bit a bank
};

}  // namespace grtx::tlm
