// A port of fast mode, which serves one item a cycle: SlotCalendar for the common case. Reservations need not come in
// the order of time.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "base/strong.h"

namespace grtx::tlm {

class PortCalendar {
 public:
  static constexpr Cycle kWindow = 8192;  ///< cycles that are kept; later ones are given out in order
  static constexpr Cycle kPeriod = 256;   ///< between two calls of advance() by an owner: few, of a large window

  /// The first cycle from `from` on that nobody has; it is taken. Past cycles are not given.
  Cycle reserve(Cycle from) {
    from = std::max(from, base_);
    std::uint64_t& word = full_[from % kWindow / 64];
    const std::uint64_t bit = std::uint64_t{1} << from % 64;
    if ((word & bit) != 0 || from >= base_ + kWindow) return reserve_later(from);
    word |= bit;
    return from;
  }
  /// Takes `count` cycles from `from` on, 1 to 63, if nobody has one of them.
  bool reserve_run(Cycle from, unsigned count) {
    if (from < base_ || from + 64 > base_ + kWindow || from % 64 + count > 64) return false;
    std::uint64_t& word = full_[from % kWindow / 64];
    const std::uint64_t run = ((std::uint64_t{1} << count) - 1) << from % 64;
    if ((word & run) != 0) return false;
    word |= run;
    return true;
  }
  /// Cycles before `now` are past.
  void advance(Cycle now) {
    while (base_ + 64 <= now) {
      full_[base_ % kWindow / 64] = 0;
      base_ += 64;
    }
  }

 private:
  Cycle reserve_later(Cycle from) {
    if (from >= base_ + kWindow) return beyond(from);
    std::uint64_t free = ~full_[from % kWindow / 64] >> from % 64;
    while (free == 0) {
      from += 64 - from % 64;
      if (from >= base_ + kWindow) return beyond(from);
      free = ~full_[from % kWindow / 64];
    }
    from += static_cast<Cycle>(std::countr_zero(free));
    full_[from % kWindow / 64] |= std::uint64_t{1} << from % 64;
    return from;
  }
  Cycle beyond(Cycle cycle) {
    cycle = std::max(cycle, beyond_);
    beyond_ = cycle + 1;
    return cycle;
  }

  Cycle base_ = 0;  ///< first cycle that is kept, a multiple of 64
  Cycle beyond_ = 0;
  std::array<std::uint64_t, kWindow / 64> full_{};
};

}  // namespace grtx::tlm
