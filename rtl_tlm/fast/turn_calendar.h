// A port of fast mode that serves one item a cycle, for clients that take turns. Who has reserved cycles ahead has no
// right to them when another comes: that one waits for one item of each of the others at most.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "base/strong.h"
#include "rtl_tlm/fast/port_calendar.h"

namespace grtx::tlm {

class TurnCalendar {
 public:
  static constexpr Cycle kWindow = PortCalendar::kWindow;  ///< cycles that are kept; later ones are given out in order
  static constexpr unsigned kNobody = ~0u;

  struct Place {
    Cycle cycle = 0;
    unsigned displaced = kNobody;  ///< the client whose cycle it was: one of its items comes later than it was told
  };

  TurnCalendar() : full_(kWindow / 64), owner_(kWindow) {}

  /// A cycle from `from` on for an item of `client`, below 256. Past cycles are not given.
  Place reserve(Cycle from, unsigned client) {
    from = std::max(from, base_);
    std::array<std::uint64_t, 4> served{};  // clients that have had their turn while this one waited
    for (Cycle at = from; at < base_ + kWindow; ++at) {
      if (!full(at)) {
        take(at, client);
        return {at, kNobody};
      }
      const unsigned owner = owner_[at % kWindow];
      const std::uint64_t bit = std::uint64_t{1} << owner % 64;
      if (owner != client && (served[owner / 64] & bit) != 0) {
        const Cycle free = first_free(at);
        if (free >= base_ + kWindow) break;
        take(free, owner);
        take(at, client);
        return {at, owner};
      }
      served[owner / 64] |= bit;
    }
    beyond_ = std::max({from, base_ + kWindow, beyond_ + 1});
    return {beyond_, kNobody};
  }
  /// Cycles before `now` are past.
  void advance(Cycle now) {
    for (; base_ + 64 <= now; base_ += 64) full_[base_ % kWindow / 64] = 0;
  }

 private:
  bool full(Cycle at) const { return (full_[at % kWindow / 64] >> at % 64 & 1) != 0; }
  void take(Cycle at, unsigned client) {
    full_[at % kWindow / 64] |= std::uint64_t{1} << at % 64;
    owner_[at % kWindow] = static_cast<std::uint8_t>(client);
  }
  Cycle first_free(Cycle from) const {
    std::uint64_t free = ~full_[from % kWindow / 64] >> from % 64;
    while (free == 0) {
      from += 64 - from % 64;
      if (from >= base_ + kWindow) return from;
      free = ~full_[from % kWindow / 64];
    }
    return from + static_cast<Cycle>(std::countr_zero(free));
  }

  Cycle base_ = 0;                   ///< first cycle that is kept, a multiple of 64
  Cycle beyond_ = 0;                 ///< given out last, of those that are not kept
  std::vector<std::uint64_t> full_;  ///< a bit a cycle
  std::vector<std::uint8_t> owner_;  ///< of those that are full
};

}  // namespace grtx::tlm
