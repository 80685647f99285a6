// A resource of fast mode that an item holds for several cycles. Reservations need not come in the order of time.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <deque>
#include <vector>

#include "grtx/base/strong.h"

namespace grtx::sim {

class SpanCalendar {
 public:
  /// Cycles that are kept. Later ones are given out in order, and are taken when they come into the window.
  static constexpr Cycle kWindow = 16384;

  /// span: cycles of an item, at least 1.
  explicit SpanCalendar(unsigned span) : span_(span), busy_(kWindow / 64) {}

  /// The first cycle from `from` on at which so many cycles are free; they are taken. Past cycles are not given.
  Cycle reserve(Cycle from) {
    const Place place = find(from);
    if (place.far) {
      beyond_ = place.first + span_;
      far_.push_back(place.first);
    } else {
      mark(place.first, span_);
    }
    return place.first;
  }
  /// What reserve() would give.
  Cycle first_free(Cycle from) const { return find(from).first; }
  /// Cycles before `now` are past.
  void advance(Cycle now) {
    if (now >= base_ + kWindow) {  // all that is kept is past
      std::fill(busy_.begin(), busy_.end(), std::uint64_t{0});
      base_ = now / 64 * 64;
    }
    while (base_ + 64 <= now) {
      busy_[base_ % kWindow / 64] = 0;
      base_ += 64;
    }
    for (; !far_.empty() && far_.front() + span_ <= base_ + kWindow; far_.pop_front()) {
      const Cycle first = std::max(far_.front(), base_), end = far_.front() + span_;
      if (first < end) mark(first, static_cast<unsigned>(end - first));
    }
  }

 private:
  struct Place {
    Cycle first;
    bool far;  ///< beyond the window
  };

  Place find(Cycle from) const {
    from = std::max(from, base_);
    const Cycle end = far_.empty() ? base_ + kWindow : std::min(base_ + kWindow, far_.front());
    unsigned free = 0;  // cycles that are free from `first` on
    Cycle first = from;
    for (Cycle at = from; free < span_;) {
      if (at + 64 > end) return {std::max(first, beyond_), true};
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
    return {first, false};
  }
  void mark(Cycle first, unsigned left) {
    while (left > 0) {
      const auto offset = static_cast<unsigned>(first % 64);
      const unsigned count = std::min(left, 64 - offset);
      const std::uint64_t bits = count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
      busy_[first % kWindow / 64] |= bits << offset;
      first += count;
      left -= count;
    }
  }
  unsigned span_;
  Cycle base_ = 0;  ///< first cycle that is kept, a multiple of 64
  Cycle beyond_ = 0;
  std::deque<Cycle> far_;            ///< given out beyond the window, ascending
  std::vector<std::uint64_t> busy_;  ///< a bit a cycle
};

}  // namespace grtx::sim
