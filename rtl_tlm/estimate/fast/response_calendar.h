// The port of an L1 to the RT unit in fast mode: a response a cycle, what has been due longest first, a hit before a
// fill that is due in the same cycle. Fills are known long before they come, and reserve first; a hit takes the place
// of one that is due no earlier.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "grtx/rtl_tlm/estimate/fast/cycle_bits.h"

namespace grtx::sim {

class ResponseCalendar {
 public:
  /// The cycle in which a fill that is due in `due` leaves. Past cycles are not given.
  Cycle reserve_fill(Cycle due) {
    due = std::max(due, cycles_.begin());
    const Cycle at = cycles_.first_free(due);
    if (at >= cycles_.end()) return cycles_.take_beyond(at);
    take(at, at - due);
    return at;
  }
  /// The cycle in which a hit that is due in `due` leaves. A fill whose cycle it takes leaves later than it was told.
  Cycle reserve_hit(Cycle due) {
    due = std::max(due, cycles_.begin());
    Cycle at = due;
    // Hits, and fills that have been due longer, go first.
    while (at < cycles_.end() && cycles_.taken(at) && (late(at) == kHit || at - late(at) < due)) ++at;
    if (at >= cycles_.end()) return cycles_.take_beyond(at);
    if (cycles_.taken(at)) {
      const Cycle end = cycles_.first_free(at);
      if (end >= cycles_.end()) return cycles_.take_beyond(end);
      for (Cycle to = end; at < to;) {  // the fills from there on move to the next cycle that no hit has
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
  /// up to `last`, if nobody has one of these cycles and they are in one word of the calendar: returns whether that is
  /// so.
  bool reserve_run(Cycle last, unsigned count, bool hits) {
    const Cycle first = last - (count - 1);
    if (!cycles_.take_run(first, count)) return false;
    std::fill_n(&late_[first % CycleBits::kWindow], count, hits ? kHit : std::uint8_t{0});
    return true;
  }
  /// Cycles before `now` are past.
  void advance(Cycle now) { cycles_.advance(now); }

 private:
  static constexpr std::uint8_t kHit = 255;

  std::uint8_t late(Cycle at) const { return late_[at % CycleBits::kWindow]; }
  void take(Cycle at, Cycle late) {
    cycles_.take(at);
    late_[at % CycleBits::kWindow] = static_cast<std::uint8_t>(std::min<Cycle>(late, kHit));
  }

  CycleBits cycles_;
  std::array<std::uint8_t, CycleBits::kWindow> late_{};  ///< of cycles taken: since when it has been due, or a hit
};

}  // namespace grtx::sim
