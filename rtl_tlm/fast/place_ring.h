// A queue as a resource: until when each of its places is taken.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "base/strong.h"

namespace grtx::tlm {

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
  /// One more enters, and leaves in cycle `until`.
  void take(Cycle until) {
    left_[next_] = until;
    next_ = next_ + 1 == left_.size() ? 0 : next_ + 1;
  }

 private:
  std::vector<Cycle> left_;
  std::size_t next_ = 0;
};

}  // namespace grtx::tlm
