// A resource of fast mode that an item holds for several cycles. Reservations need not come in the order of time.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "grtx/base/strong.h"

namespace grtx::sim {

class SpanCalendar {
 public:
  static constexpr Cycle kWindow = 16384;  ///< cycles that are kept; later ones are given out in order

  /// span: cycles of an item, at least 1.
  explicit SpanCalendar(unsigned span) : span_(span), busy_(kWindow / 64) {}

  /// The first cycle from `from` on at which so many cycles are free; they are taken. Past cycles are not given.
  Cycle reserve(Cycle from) {
    from = std::max(from, base_);
    unsigned free = 0;  // cycles that are free from `first` on
    Cycle first = from;
    for (Cycle at = from; free < span_;) {
      if (at + 64 > base_ + kWindow) return beyond(first);
      const std::uint64_t busy = busy_[at % kWindow / 64] >> at % 64;
      const auto left = static_cast<unsigned>(64 - at % 64);
      const unsigned run = busy == 0 ? left : static_cast<unsigned>(std::countr_zero(busy));
      free += run;
      at += run;
      if (run == left || free >= span_) continue;
      at += static_cast<Cycle>(std::countr_one(busy >> run));
      first = at;
      free = 0;
    }
    mark(first);
    return first;
  }
  /// Cycles before `now` are past.
  void advance(Cycle now) {
    while (base_ + 64 <= now) {
      busy_[base_ % kWindow / 64] = 0;
      base_ += 64;
    }
  }

 private:
  void mark(Cycle first) {
    for (unsigned left = span_; left > 0;) {
      const auto offset = static_cast<unsigned>(first % 64);
      const unsigned count = std::min(left, 64 - offset);
      const std::uint64_t bits = count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
      busy_[first % kWindow / 64] |= bits << offset;
      first += count;
      left -= count;
    }
  }
  Cycle beyond(Cycle cycle) {
    cycle = std::max(cycle, beyond_);
    beyond_ = cycle + span_;
    return cycle;
  }

  unsigned span_;
  Cycle base_ = 0;  ///< first cycle that is kept, a multiple of 64
  Cycle beyond_ = 0;
  std::vector<std::uint64_t> busy_;  ///< a bit a cycle
};

}  // namespace grtx::sim
