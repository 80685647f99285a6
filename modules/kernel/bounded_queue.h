// SPDX-License-Identifier: Apache-2.0
// A first-in first-out queue of fixed capacity in one allocation: a hardware queue that can be full.
#pragma once

#include <cassert>
#include <cstddef>
#include <vector>

namespace grtx::modules {

template <typename T>
class BoundedQueue {
 public:
  explicit BoundedQueue(std::size_t capacity) : slots_(capacity) { assert(capacity > 0); }

  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  std::size_t capacity() const { return slots_.size(); }
  std::size_t room() const { return slots_.size() - size_; }
  T& front() {
    assert(size_ > 0);
    return slots_[head_];
  }
  const T& front() const {
    assert(size_ > 0);
    return slots_[head_];
  }
  /// Item `i` places behind the front.
  T& at(std::size_t i) {
    assert(i < size_);
    return slots_[index(i)];
  }
  const T& at(std::size_t i) const {
    assert(i < size_);
    return slots_[index(i)];
  }
  void push(const T& item) {
    assert(size_ < slots_.size());
    slots_[index(size_)] = item;
    ++size_;
  }
  void pop() {
    assert(size_ > 0);
    head_ = head_ + 1 == slots_.size() ? 0 : head_ + 1;
    if (--size_ == 0) head_ = 0;  // reuses the same few cache lines of the host
  }
  void clear() { head_ = size_ = 0; }

 private:
  std::size_t index(std::size_t i) const {
    const std::size_t at = head_ + i;
    return at >= slots_.size() ? at - slots_.size() : at;
  }
  std::vector<T> slots_;
  std::size_t head_ = 0;
  std::size_t size_ = 0;
};

}  // namespace grtx::modules
