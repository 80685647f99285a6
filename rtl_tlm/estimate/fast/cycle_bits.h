// Which cycles of a window that moves with the time are taken: what the calendars of things that serve one item a cycle
// have in common.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <deque>

#include "grtx/base/strong.h"

namespace grtx::sim {

class CycleBits {
 public:
  /// Cycles that are kept. Later ones are given out in order, and taken when they come into the window.
  static constexpr Cycle kWindow = 8192;
  static constexpr Cycle kNone = ~Cycle{0};

  Cycle begin() const { return begin_; }  ///< first cycle that is kept, a multiple of 64
  Cycle end() const { return begin_ + kWindow; }
  /// at: a cycle that is kept.
  bool taken(Cycle at) const { return (bits_[at % kWindow / 64] >> at % 64 & 1) != 0; }
  void take(Cycle at) { bits_[at % kWindow / 64] |= std::uint64_t{1} << at % 64; }
  void leave(Cycle at) { bits_[at % kWindow / 64] &= ~(std::uint64_t{1} << at % 64); }
  /// Takes `count` cycles from `first` on, 1 to 63, if all are kept and free, and in one word: returns whether it did.
  bool take_run(Cycle first, unsigned count) {
    if (first < begin_ || first + 64 > end() || first % 64 + count > 64) return false;
    std::uint64_t& word = bits_[first % kWindow / 64];
    const std::uint64_t run = ((std::uint64_t{1} << count) - 1) << first % 64;
    if ((word & run) != 0) return false;
    word |= run;
    return true;
  }
  /// The first free cycle from `from` on, which is not before begin(); if none is kept, one from end() on.
  Cycle first_free(Cycle from) const {
    while (from < end()) {
      const std::uint64_t free = ~bits_[from % kWindow / 64] >> from % 64;
      if (free != 0) return from + static_cast<Cycle>(std::countr_zero(free));
      from += 64 - from % 64;
    }
    return from;
  }
  /// f(cycle) for those that are taken, and kept, from `from` on and before `to`, in order, until it returns false.
  template <typename F>
  void for_each_taken(Cycle from, Cycle to, F&& f) const {
    from = std::max(from, begin_);
    to = std::min(to, end());
    for (; from < to; from += 64 - from % 64) {
      for (std::uint64_t taken = bits_[from % kWindow / 64] >> from % 64; taken != 0; taken &= taken - 1) {
        const Cycle at = from + static_cast<Cycle>(std::countr_zero(taken));
        if (at >= to || !f(at)) return;
      }
    }
  }
  /// The first of them; kNone: none is.
  Cycle first_taken(Cycle from, Cycle to) const {
    Cycle first = kNone;
    for_each_taken(from, to, [&](Cycle at) {
      first = at;
      return false;
    });
    return first;
  }
  /// The same as for_each_taken(), the last first.
  template <typename F>
  void for_each_taken_back(Cycle from, Cycle to, F&& f) const {
    from = std::max(from, begin_);
    to = std::min(to, end());
    while (from < to) {
      const Cycle word = (to - 1) / 64 * 64;
      for (std::uint64_t taken = bits_[word % kWindow / 64] << (63 - (to - 1) % 64); taken != 0;) {
        const auto back = static_cast<unsigned>(std::countl_zero(taken));
        const Cycle at = to - 1 - back;
        if (at < from || !f(at)) return;
        taken &= ~(std::uint64_t{1} << (63 - back));
      }
      to = word;
    }
  }
  /// A cycle from `from` on, not before end(): they are given in order, `distance` apart.
  Cycle take_beyond(Cycle from, Cycle distance = 1) {
    from = std::max(from, beyond_);
    beyond_ = from + distance;
    far_.push_back(from);
    return from;
  }
  /// Cycles before `now` are past.
  void advance(Cycle now) {
    if (now >= end()) {  // all that is kept is past
      bits_.fill(0);
      begin_ = now / 64 * 64;
    }
    for (; begin_ + 64 <= now; begin_ += 64) bits_[begin_ % kWindow / 64] = 0;
    for (; !far_.empty() && far_.front() < end(); far_.pop_front()) {
      if (far_.front() >= begin_) take(far_.front());
    }
  }

 private:
  Cycle begin_ = 0;
  Cycle beyond_ = 0;
  std::deque<Cycle> far_;  ///< given out beyond the window
  std::array<std::uint64_t, kWindow / 64> bits_{};
};

}  // namespace grtx::sim
