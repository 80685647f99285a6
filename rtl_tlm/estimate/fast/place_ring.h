// A queue as a resource: until when each of its places is taken.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "grtx/base/strong.h"

namespace grtx::sim {

/// Items leave in the order in which they enter: there is room when the one that entered so many places ago has left.
class PlaceRing {
 public:
  explicit PlaceRing(std::size_t places) : left_(std::max<std::size_t>(1, places)) {}

  /// When there is room for one more.
  Cycle room() const { return left_[next_]; }
  /// When there is room for `count` more, of which each leaves after those before it. More than there are places: for
  /// as many as there are.
  Cycle room(std::size_t count) const {
    const std::size_t last = next_ + std::min(count, left_.size()) - 1;
    return left_[last < left_.size() ? last : last - left_.size()];
  }
  /// `count` more enter, which leave in cycle `until`.
  void take(Cycle until, std::size_t count) {
    for (; count > 0; --count) take(until);
  }
  /// `count` more enter, at least one, which leave one a cycle, the last of them in cycle `until`. Returns when there
  /// was room for the last of them.
  Cycle take_in_turn(Cycle until, std::size_t count) {
    Cycle* const left = left_.data();
    const std::size_t places = left_.size();
    std::size_t next = next_;
    Cycle room = 0;
    for (Cycle at = until - (count - 1); at <= until; ++at) {
      room = std::exchange(left[next], at);
      next = next + 1 == places ? 0 : next + 1;
    }
    next_ = next;
    return room;
  }
  /// One more enters, and leaves in cycle `until`.
  void take(Cycle until) {
    left_[next_] = until;
    next_ = next_ + 1 == left_.size() ? 0 : next_ + 1;
  }

 private:
  std::vector<Cycle> left_;
  std::size_t next_ = 0;
};

}  // namespace grtx::sim
