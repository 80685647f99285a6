// SPDX-License-Identifier: Apache-2.0
// A FIFO in a growable ring buffer: no allocation once it has reached its largest size. Used inside the memory modules.
#pragma once

#include <cassert>
#include <cstddef>
#include <vector>

namespace grtx::modules {

template <typename T>
class RingQueue {
 public:
  explicit RingQueue(std::size_t reserve = 16) {
    std::size_t capacity = 1;
    while (capacity < reserve) capacity *= 2;
    slots_.resize(capacity);
    mask_ = capacity - 1;
  }

  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  T& front() {
    assert(size_ > 0);
    return slots_[head_];
  }
  const T& front() const {
    assert(size_ > 0);
    return slots_[head_];
  }
  /// i = 0 is the oldest item.
  T& operator[](std::size_t i) {
    assert(i < size_);
    return slots_[(head_ + i) & mask_];
  }
  const T& operator[](std::size_t i) const {
    assert(i < size_);
    return slots_[(head_ + i) & mask_];
  }
  void push(const T& item) { add() = item; }
  /// Adds an item and returns it; what it holds is unspecified.
  T& add() {
    if (size_ > mask_) [[unlikely]]
      grow();
    return slots_[(head_ + size_++) & mask_];
  }
  void pop() {
    assert(size_ > 0);
    head_ = (head_ + 1) & mask_;
    if (--size_ == 0) head_ = 0;  // reuses the same few cache lines of the host
  }
  void clear() { head_ = size_ = 0; }

 private:
  [[gnu::noinline]] void grow() {
    std::vector<T> bigger(slots_.size() * 2);
    for (std::size_t i = 0; i < size_; ++i) bigger[i] = (*this)[i];
    slots_.swap(bigger);
    mask_ = slots_.size() - 1;
    head_ = 0;
  }

  std::vector<T> slots_;
  std::size_t mask_ = 0;  ///< number of slots, a power of two, minus one
  std::size_t head_ = 0;
  std::size_t size_ = 0;
};

}  // namespace grtx::modules
