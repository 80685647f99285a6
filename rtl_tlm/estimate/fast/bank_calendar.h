// The banks of a cache in fast mode: each serves one sector a cycle. Cycles need not be asked for in the order of time.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "grtx/base/strong.h"

namespace grtx::sim {

class BankCalendar {
 public:
  static constexpr Cycle kWindow = 4096;  ///< cycles that are kept; later ones are given to whoever asks

  /// banks: 1 to 64.
  explicit BankCalendar(unsigned banks)
      : banks_(banks), power_of_two_(std::has_single_bit(banks)), busy_(std::size_t{banks} * kWords) {}

  /// Number of the bank that holds a sector.
  unsigned bank(std::uint64_t sector) const {
    return static_cast<unsigned>(power_of_two_ ? sector & (banks_ - 1) : sector % banks_);
  }
  /// The first cycle from `from` on in which the bank is free; it is taken. Past cycles are not given.
  Cycle reserve(unsigned bank, Cycle from) {
    for (from = std::max(from, base_); from < base_ + kWindow; ++from) {
      std::uint64_t& busy = word(bank, from);
      const std::uint64_t bit = std::uint64_t{1} << from % 64;
      if ((busy & bit) != 0) continue;
      busy |= bit;
      break;
    }
    return from;
  }
  /// Takes the banks of `count` consecutive sectors, up to 32, in consecutive cycles from `from` on, if all are free.
  bool reserve_run(unsigned bank, Cycle from, unsigned count) {
    const auto offset = static_cast<unsigned>(from % 64);
    if (from >= base_ && offset + count <= 64 && from + 64 <= base_ + kWindow) {
      std::uint64_t& busy = word(bank, from);
      const std::uint64_t bits = ((std::uint64_t{1} << count) - 1) << offset;
      if ((busy & bits) != 0) return false;
      busy |= bits;
      return true;
    }
    const Run run = run_of(bank, from, count);
    if (((*run.low & run.low_bits) | (*run.high & run.high_bits)) != 0) return false;
    take(run);
    return true;
  }
  /// Takes them although somebody has one of them, who has to wait.
  void share_run(unsigned bank, Cycle from, unsigned count) { take(run_of(bank, from, count)); }
  /// Cycles before `now` are past.
  void advance(Cycle now) {
    if (now >= base_ + kWindow) {  // all that is kept is past
      std::fill(busy_.begin(), busy_.end(), std::uint64_t{0});
      base_ = now / 64 * 64;
    }
    for (; base_ + 64 <= now; base_ += 64) {
      for (unsigned i = 0; i < banks_; ++i) busy_[i * kWords + base_ % kWindow / 64] = 0;
    }
  }

 private:
  static constexpr std::size_t kWords = kWindow / 64;

  struct Run {
    std::uint64_t* low;
    std::uint64_t* high;
    std::uint64_t low_bits, high_bits;
  };
  Run run_of(unsigned bank, Cycle from, unsigned count) {
    if (from < base_ || from + count > base_ + kWindow) return {&beyond_, &beyond_, 0, 0};
    const std::uint64_t bits = (std::uint64_t{1} << count) - 1;
    const std::uint64_t high = from % 64 == 0 ? 0 : bits >> (64 - from % 64);
    std::uint64_t* low = &word(bank, from);
    return {low, high == 0 ? low : &word((bank + count - 1) % banks_, from + count - 1), bits << from % 64, high};
  }
  static void take(const Run& run) {
    *run.low |= run.low_bits;
    *run.high |= run.high_bits;
  }
  // Sector s + i in cycle c + i, for all i, are a diagonal, and neighbours in a word.
  std::uint64_t& word(unsigned bank, Cycle cycle) {
    const unsigned diagonal = power_of_two_ ? (bank - static_cast<unsigned>(cycle)) & (banks_ - 1)
                                            : (bank + banks_ - static_cast<unsigned>(cycle % banks_)) % banks_;
    return busy_[diagonal * kWords + cycle % kWindow / 64];
  }

  unsigned banks_;
  bool power_of_two_;                ///< banks
  Cycle base_ = 0;                   ///< first cycle that is kept, a multiple of 64
  std::uint64_t beyond_ = 0;         ///< cycles that are not kept
  std::vector<std::uint64_t> busy_;  ///< by diagonal: a bit a cycle
};

}  // namespace grtx::sim
