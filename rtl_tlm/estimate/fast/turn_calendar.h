// A port of fast mode that serves one item a cycle, for clients that take turns. Who has reserved cycles ahead has no
// right to them when another comes: that one waits for one item of each of the others at most.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "grtx/rtl_tlm/estimate/fast/cycle_bits.h"

namespace grtx::sim {

class TurnCalendar {
 public:
  static constexpr unsigned kNobody = ~0u;

  struct Place {
    Cycle cycle = 0;
    unsigned displaced = kNobody;  ///< the client whose cycle it was: one of its items comes later than it was told
  };

  /// A cycle from `from` on for an item of `client`, below 256. Past cycles are not given.
  Place reserve(Cycle from, unsigned client) {
    from = std::max(from, cycles_.begin());
    std::array<std::uint64_t, 4> served{};  // clients that have had their turn while this one waited
    Cycle at = from;
    for (; at < cycles_.end() && cycles_.taken(at); ++at) {
      const unsigned owner = owner_[at % CycleBits::kWindow];
      const std::uint64_t bit = std::uint64_t{1} << owner % 64;
      if (owner != client && (served[owner / 64] & bit) != 0) {
        const Cycle free = cycles_.first_free(at);
        if (free >= cycles_.end()) return {cycles_.take_beyond(free), kNobody};
        take(free, owner);
        take(at, client);
        return {at, owner};
      }
      served[owner / 64] |= bit;
    }
    if (at >= cycles_.end()) return {cycles_.take_beyond(at), kNobody};
    take(at, client);
    return {at, kNobody};
  }
  /// Cycles before `now` are past.
  void advance(Cycle now) { cycles_.advance(now); }

 private:
  void take(Cycle at, unsigned client) {
    cycles_.take(at);
    owner_[at % CycleBits::kWindow] = static_cast<std::uint8_t>(client);
  }

  CycleBits cycles_;
  std::array<std::uint8_t, CycleBits::kWindow> owner_{};  ///< of cycles taken
};

}  // namespace grtx::sim
