// When a DRAM channel of fast mode opens rows: an activate keeps its distances to all others, earlier and later, and no
// five begin within tFAW. Reservations need not come in the order of time.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "grtx/modules/dram/dram_config.h"
#include "grtx/rtl_tlm/estimate/fast/cycle_bits.h"

namespace grtx::sim {

class ActivateCalendar {
 public:
  explicit ActivateCalendar(const modules::DramTiming& t)
      : distance_{std::max(1u, t.rrd), std::max(1u, t.rrd_of_group())},
        faw_(t.faw),
        reach_(std::max(distance_[1], faw_)) {}

  /// The first clock from `from` on in which a bank of `group` can open a row; it is taken. Past clocks are not given.
  Cycle reserve(Cycle from, unsigned group) {
    Cycle at = std::max(from, clocks_.begin());
    for (Cycle free = at; at < clocks_.end(); at = free) {
      free = allowed(at, group);
      if (free != at) continue;
      clocks_.take(at);
      group_[at % CycleBits::kWindow] = static_cast<std::uint8_t>(group);
      return at;
    }
    return clocks_.take_beyond(at, std::max(distance_[0], (faw_ + 3) / 4));
  }
  /// Nothing begins before clock `now` any more; what began shortly before it still counts.
  void advance(Cycle now) { clocks_.advance(now - std::min({now, reach_, CycleBits::kWindow / 2})); }

 private:
  /// `at` if it may be taken, else a later clock before which none may.
  Cycle allowed(Cycle at, unsigned group) const {
    const Cycle begin = at - std::min(at, distance_[1] - 1);
    for (Cycle other = begin; (other = clocks_.first_taken(other, at + distance_[1])) != CycleBits::kNone; ++other) {
      const Cycle distance = distance_[group_[other % CycleBits::kWindow] == group ? 1 : 0];
      if (other + distance > at && at + distance > other) return other + distance;
    }
    return faw_ == 0 ? at : outside_window(at);
  }
  /// Of any five in a row that would have `at` among them, the first and the last are tFAW apart.
  Cycle outside_window(Cycle at) const {
    std::array<Cycle, 9> near{};
    std::size_t first = 4, end = 5;
    for (near[4] = at; first > 0; --first) {
      near[first - 1] = clocks_.last_taken(at - std::min(at, faw_ - 1), near[first]);
      if (near[first - 1] == CycleBits::kNone) break;
    }
    for (; end < 9; ++end) {
      near[end] = clocks_.first_taken(near[end - 1] + 1, at + faw_);
      if (near[end] == CycleBits::kNone) break;
    }
    for (; first + 4 < end; ++first) {
      if (near[first] + faw_ > near[first + 4]) return std::max(at + 1, near[first] + faw_);
    }
    return at;
  }

  std::array<Cycle, 2> distance_;  ///< to one of another bank group, of the same
  Cycle faw_;
  Cycle reach_;  ///< the longest distance
  CycleBits clocks_;
  std::array<std::uint8_t, CycleBits::kWindow> group_{};
};

}  // namespace grtx::sim
