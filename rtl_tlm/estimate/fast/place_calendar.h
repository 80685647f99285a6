// So many places as a resource, each taken until a cycle of its own: they become free in any order.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "grtx/base/strong.h"

namespace grtx::sim {

class PlaceCalendar {
 public:
  static constexpr Cycle kWindow = 8192;  ///< what is taken for longer is free that much later

  explicit PlaceCalendar(std::size_t places)
      : places_(std::max<std::size_t>(1, places)), leaving_(kWindow), some_(kWindow / 64) {}

  /// Whether no place is free in cycle `from`.
  bool full(Cycle from) {
    free_until(from);
    return taken_ >= places_;
  }
  /// The first cycle from `from` on in which a place is free; not before one that was asked for already, of which only
  /// the later state is known.
  Cycle room(Cycle from) {
    free_until(from);
    while (taken_ >= places_) free_until(next());
    return std::max(from, freed_);
  }
  /// Takes `count` places from the present until cycle `until`. More than there are may be taken: they count when
  /// others leave.
  void take(Cycle until, unsigned count = 1) {
    until = std::clamp(until, freed_ + 1, freed_ + kWindow - 1);
    std::uint32_t& leaving = leaving_[until % kWindow];
    leaving += count;
    some_[until % kWindow / 64] |= std::uint64_t{1} << until % 64;
    taken_ += count;
  }

 private:
  /// The first cycle after the last one looked at in which somebody leaves.
  Cycle next() const {
    for (Cycle at = freed_ + 1;;) {
      const std::uint64_t left = some_[at % kWindow / 64] >> at % 64;
      if (left != 0) return at + static_cast<Cycle>(std::countr_zero(left));
      at += 64 - at % 64;
    }
  }
  void free_until(Cycle cycle) {
    while (taken_ > 0) {
      const Cycle at = next();
      if (at > cycle) break;
      taken_ -= leaving_[at % kWindow];
      leaving_[at % kWindow] = 0;
      some_[at % kWindow / 64] &= ~(std::uint64_t{1} << at % 64);
      freed_ = at;
    }
    freed_ = std::max(freed_, cycle);
  }

  std::size_t places_;
  std::size_t taken_ = 0;
  Cycle freed_ = 0;                     ///< who leaves up to this cycle has left
  std::vector<std::uint32_t> leaving_;  ///< by cycle
  std::vector<std::uint64_t> some_;     ///< a bit a cycle: somebody leaves
};

}  // namespace grtx::sim
