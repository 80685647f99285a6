// SPDX-License-Identifier: Apache-2.0
// The registered queue between two plain units: what is pushed in cycle c is seen from c + latency on, and a place that
// is freed in cycle c is free from c + 1 on. So the order in which units tick within a cycle does not matter.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <utility>

namespace grtx::sim::plain {

using Cycle = std::uint64_t;

template <typename T>
class Channel {
 public:
  Channel(unsigned latency, std::size_t capacity) : latency_(latency), capacity_(capacity) {}

  bool has_room(Cycle now) const { return items_.size() + (last_pop_ == now ? popped_ : 0) < capacity_; }
  void push(Cycle now, T item) { items_.emplace_back(now + latency_, std::move(item)); }
  /// The oldest item if it is there in cycle `now`, else nullptr.
  const T* front(Cycle now) const {
    return !items_.empty() && items_.front().first <= now ? &items_.front().second : nullptr;
  }
  T pop(Cycle now) {
    if (last_pop_ != now) popped_ = 0;
    last_pop_ = now;
    ++popped_;
    T item = std::move(items_.front().second);
    items_.pop_front();
    return item;
  }
  bool empty() const { return items_.empty(); }

 private:
  unsigned latency_;
  std::size_t capacity_;
  std::deque<std::pair<Cycle, T>> items_;
  Cycle last_pop_ = ~Cycle{0};
  std::size_t popped_ = 0;  ///< in cycle last_pop_
};

}  // namespace grtx::sim::plain
