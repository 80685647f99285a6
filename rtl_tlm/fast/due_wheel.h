// Numbered things (lanes, misses) by the cycle in which each is due; a number is in it once. Adding and taking cost a
// few instructions, however many there are.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstdint>
#include <vector>

#include "modules/clock_domain.h"

namespace grtx::tlm {

class DueWheel {
 public:
  using Number = std::uint16_t;
  static constexpr Number kNone = 0xFFFF;

  explicit DueWheel(std::size_t numbers) : next_(numbers, kNone) { heads_.fill(kNone); }

  bool empty() const { return size_ == 0; }
  /// now: the present cycle. What is due before a cycle that has been taken is due in the next.
  void add(Cycle now, Cycle due, Number number) {
    if (size_ == 0) taken_ = std::max(taken_, now);
    due = std::max(due, taken_ + 1);
    ++size_;
    if (due - taken_ >= kWindow) {
      far_.push_back({due, number});
      next_due_ = std::min(next_due_, due);
      return;
    }
    const std::size_t bucket = due % kWindow;
    next_[number] = heads_[bucket];
    heads_[bucket] = number;
    filled_[bucket / 64] |= std::uint64_t{1} << bucket % 64;
    next_due_ = std::min(next_due_, due);
  }
  /// Earliest due cycle; kNever when empty.
  Cycle next() const { return next_due_; }
  /// One of those that are due in cycle next(), or kNone: it may not say.
  Number peek() const { return next_due_ == modules::kNever ? kNone : heads_[next_due_ % kWindow]; }
  /// f(number) for all that are due in cycle `now`, which must be next() or earlier. f may add.
  template <typename F>
  void take(Cycle now, F&& f) {
    if (next_due_ > now) return;
    assert(next_due_ == now);
    taken_ = now;
    const std::size_t bucket = now % kWindow;
    Number number = heads_[bucket];
    heads_[bucket] = kNone;
    filled_[bucket / 64] &= ~(std::uint64_t{1} << bucket % 64);
    next_due_ = find_next();
    while (number != kNone) {
      const Number following = next_[number];
      --size_;
      f(number);
      number = following;
    }
    for (std::size_t i = 0; i < far_.size();) {
      if (far_[i].due != now) {
        ++i;
        continue;
      }
      const Number due = far_[i].number;
      far_.erase(far_.begin() + static_cast<std::ptrdiff_t>(i));
      --size_;
      f(due);
    }
  }

 private:
  static constexpr Cycle kWindow = 2048;
  struct Far {
    Cycle due;
    Number number;
  };

  // The first filled bucket after taken_, or what is far.
  Cycle find_next() const {
    Cycle found = modules::kNever;
    for (const Far& far : far_) {
      if (far.due > taken_) found = std::min(found, far.due);
    }
    const Cycle start = taken_ + 1;
    for (Cycle checked = 0; checked < kWindow;) {
      const Cycle cycle = start + checked;
      const std::uint64_t word = filled_[cycle % kWindow / 64] >> cycle % 64;
      if (word != 0) return std::min(found, cycle + static_cast<Cycle>(std::countr_zero(word)));
      checked += 64 - cycle % 64;
    }
    return found;
  }

  std::array<Number, kWindow> heads_;
  std::array<std::uint64_t, kWindow / 64> filled_{};
  std::vector<Number> next_;
  std::vector<Far> far_;
  std::size_t size_ = 0;
  Cycle taken_ = 0;  ///< last cycle that was taken
  Cycle next_due_ = modules::kNever;
};

}  // namespace grtx::tlm
