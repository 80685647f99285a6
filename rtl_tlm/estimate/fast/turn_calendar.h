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
  /// A cycle from `from` on for an item of `client`, below 256. Past cycles are not given. Where that cycle was
  /// another's, delayed(other) is called once for each client with items from there to the next free cycle: the last of
  /// them comes a cycle later than it was told.
  template <typename Delayed>
  Cycle reserve(Cycle from, unsigned client, Delayed&& delayed) {
    from = std::max(from, cycles_.begin());
    Clients served{};  // have had their turn while this one waited
    Cycle at = from;
    for (; at < cycles_.end() && cycles_.taken(at); ++at) {
      const unsigned owner = owner_[at % CycleBits::kWindow];
      if (owner != client && served.has(owner)) {
        const Cycle free = cycles_.first_free(at);
        if (free >= cycles_.end()) return cycles_.take_beyond(free);
        push_back(at, free, client, delayed);
        return at;
      }
      served.add(owner);
    }
    if (at >= cycles_.end()) return cycles_.take_beyond(at);
    take(at, client);
    return at;
  }
  /// Cycles before `now` are past.
  void advance(Cycle now) { cycles_.advance(now); }

 private:
  struct Clients {
    std::array<std::uint64_t, 4> bits{};
    bool has(unsigned client) const { return (bits[client / 64] >> client % 64 & 1) != 0; }
    void add(unsigned client) { bits[client / 64] |= std::uint64_t{1} << client % 64; }
  };
  template <typename Delayed>
  void push_back(Cycle at, Cycle free, unsigned client, Delayed&& delayed) {
    Clients behind{};
    for (Cycle later = at; later < free; ++later) {
      const unsigned owner = owner_[later % CycleBits::kWindow];
      if (owner == client || behind.has(owner)) continue;
      behind.add(owner);
      delayed(owner);
    }
    take(free, owner_[at % CycleBits::kWindow]);
    take(at, client);
  }
  void take(Cycle at, unsigned client) {
    cycles_.take(at);
    owner_[at % CycleBits::kWindow] = static_cast<std::uint8_t>(client);
  }

  CycleBits cycles_;
  std::array<std::uint8_t, CycleBits::kWindow> owner_{};  ///< of cycles taken
};

}  // namespace grtx::sim
