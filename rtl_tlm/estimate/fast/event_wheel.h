// Numbered things by the cycle in which each is due, for a whole machine: a calendar of linked lists. A number is in it
// once at most.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <functional>
#include <queue>
#include <utility>
#include <vector>

#include "grtx/base/strong.h"

namespace grtx::sim {

class EventWheel {
 public:
  using Number = std::uint32_t;

  /// numbers: how many things there are.
  explicit EventWheel(std::size_t numbers) : heads_(kWindow, kNone), filled_(kWindow / 64), next_(numbers, kNone) {}

  Cycle now() const { return now_; }
  std::uint64_t steps() const { return steps_; }  ///< cycles in which something was due
  /// Due in cycle `at`, or in the next one if that is past.
  void add(Cycle at, Number number) {
    at = std::max(at, now_ + 1);
    ++size_;
    if (at - now_ >= kWindow) {
      far_.push({at, number});
    } else {
      link(at, number);
    }
  }
  /// f(number) for all in the order of time, until none is left. f may add.
  template <typename F>
  void run(F&& f) {
    while (size_ > 0) {
      move_to_next();
      ++steps_;
      const std::size_t bucket = now_ % kWindow;
      Number number = heads_[bucket];
      heads_[bucket] = kNone;
      filled_[bucket / 64] &= ~(std::uint64_t{1} << bucket % 64);
      while (number != kNone) {
        const Number following = next_[number];
        --size_;
        f(number);
        number = following;
      }
    }
  }

 private:
  static constexpr Cycle kWindow = 2048;
  static constexpr Number kNone = ~Number{0};
  using Far = std::pair<Cycle, Number>;

  void link(Cycle at, Number number) {
    const std::size_t bucket = at % kWindow;
    next_[number] = heads_[bucket];
    heads_[bucket] = number;
    filled_[bucket / 64] |= std::uint64_t{1} << bucket % 64;
  }
  void move_to_next() {
    Cycle due = far_.empty() ? ~Cycle{0} : far_.top().first;
    for (Cycle ahead = 1; ahead < kWindow;) {
      const Cycle cycle = now_ + ahead;
      const std::uint64_t word = filled_[cycle % kWindow / 64] >> cycle % 64;
      if (word != 0) {
        due = std::min(due, cycle + static_cast<Cycle>(std::countr_zero(word)));
        break;
      }
      ahead += 64 - cycle % 64;
    }
    now_ = due;
    while (!far_.empty() && far_.top().first - now_ < kWindow) {
      link(far_.top().first, far_.top().second);
      far_.pop();
    }
  }

  std::vector<Number> heads_;
  std::vector<std::uint64_t> filled_;
  std::vector<Number> next_;
  std::priority_queue<Far, std::vector<Far>, std::greater<>> far_;
  std::size_t size_ = 0;
  Cycle now_ = 0;
  std::uint64_t steps_ = 0;
};

}  // namespace grtx::sim
