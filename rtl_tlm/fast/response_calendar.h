// The port of an L1 to the RT unit in fast mode: a response a cycle, what has been due longest first, a hit before a
// fill that is due in the same cycle. Fills are known long before they come, and reserve first; a hit takes the place
// of one that is due no earlier.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "base/strong.h"
#include "rtl_tlm/fast/port_calendar.h"

namespace grtx::tlm {

class ResponseCalendar {
 public:
  static constexpr Cycle kWindow = PortCalendar::kWindow;  ///< cycles that are kept; later ones are given out in order

  /// The cycle in which a fill that is due in `due` leaves. Past cycles are not given.
  Cycle reserve_fill(Cycle due) {
    due = std::max(due, base_);
    const Cycle at = first_free(due);
    if (at >= base_ + kWindow) return beyond(at);
    take(at, at - due);
    return at;
  }
  /// The cycle in which a hit that is due in `due` leaves. A fill whose cycle it takes leaves later than it was told.
  Cycle reserve_hit(Cycle due) {
    due = std::max(due, base_);
    Cycle at = due;
    // Hits, and fills that have been due longer, go first.
    while (at < base_ + kWindow && full(at) && (late(at) == kHit || at - late(at) < due)) ++at;
    if (at >= base_ + kWindow) return beyond(at);
    if (full(at)) {
      const Cycle end = first_free(at);
      if (end >= base_ + kWindow) return beyond(end);
      for (Cycle from = at, to = end; from < to;) {  // the fills behind it move to the next cycle that no hit has
        Cycle before = to - 1;
        while (late(before) == kHit) --before;
        take(to, to - before + late(before));
        to = before;
      }
    }
    take(at, kHit);
    return at;
  }
  /// As one after the other, from the first on, `count` hits or fills (at most 63) that are due in consecutive cycles
  /// up to `last`, when nobody has one of these cycles: returns whether that is so.
  bool reserve_run(Cycle last, unsigned count, bool hits) {
    const Cycle first = last - (count - 1);
    const auto offset = static_cast<unsigned>(first % 64);
    if (first < base_ || offset + count > 64 || first + 64 > base_ + kWindow) return false;
    std::uint64_t& full = full_[first % kWindow / 64];
    const std::uint64_t bits = ((std::uint64_t{1} << count) - 1) << offset;
    if ((full & bits) != 0) return false;
    full |= bits;
    std::fill_n(&late_[first % kWindow], count, hits ? kHit : std::uint8_t{0});
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
  static constexpr std::uint8_t kHit = 255;

  bool full(Cycle at) const { return (full_[at % kWindow / 64] >> at % 64 & 1) != 0; }
  std::uint8_t late(Cycle at) const { return late_[at % kWindow]; }
  void take(Cycle at, Cycle late) {
    full_[at % kWindow / 64] |= std::uint64_t{1} << at % 64;
    late_[at % kWindow] = static_cast<std::uint8_t>(std::min<Cycle>(late, kHit));
  }
  Cycle first_free(Cycle from) const {
    if (from >= base_ + kWindow) return from;
    std::uint64_t free = ~full_[from % kWindow / 64] >> from % 64;
    while (free == 0) {
      from += 64 - from % 64;
      if (from >= base_ + kWindow) return from;
      free = ~full_[from % kWindow / 64];
    }
    return from + static_cast<Cycle>(std::countr_zero(free));
  }
  Cycle beyond(Cycle cycle) {
    cycle = std::max(cycle, beyond_);
    beyond_ = cycle + 1;
    return cycle;
  }

  Cycle base_ = 0;  ///< first cycle that is kept, a multiple of 64
  Cycle beyond_ = 0;
  std::array<std::uint64_t, kWindow / 64> full_{};
  std::array<std::uint8_t, kWindow> late_{};  ///< of those that are full: cycles since it has been due, or a hit
};

}  // namespace grtx::tlm
