// A port of fast mode, which serves one item a cycle: SlotCalendar for the common case. Reservations need not come in
// the order of time.
#pragma once

#include <algorithm>

#include "grtx/rtl_tlm/estimate/fast/cycle_bits.h"

namespace grtx::sim {

class PortCalendar {
 public:
  static constexpr Cycle kPeriod = 256;  ///< between two calls of advance() by an owner: few, of a large window

  /// The first cycle from `from` on that nobody has; it is taken. Past cycles are not given.
  Cycle reserve(Cycle from) {
    const Cycle at = cycles_.first_free(std::max(from, cycles_.begin()));
    if (at >= cycles_.end()) return cycles_.take_beyond(at);
    cycles_.take(at);
    return at;
  }
  /// Takes `count` cycles from `from` on, 1 to 63, if nobody has one of them and they are in one word of the calendar.
  bool reserve_run(Cycle from, unsigned count) { return cycles_.take_run(from, count); }
  /// Cycles before `now` are past.
  void advance(Cycle now) { cycles_.advance(now); }

 private:
  CycleBits cycles_;
};

}  // namespace grtx::sim
