// SPDX-License-Identifier: Apache-2.0
// A channel that is not a Link: what a user's own implementation of link_in_if and link_out_if looks like.
#pragma once

#include <cassert>
#include <deque>
#include <string>
#include <utility>

#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/link_if.h"

namespace grtx::modules {

/// Behaves as a Link of this latency and capacity, written down in the plainest way.
template <typename T>
class ForeignChannel final : public link_in_if<T>, public link_out_if<T> {
 public:
  ForeignChannel(unsigned latency, std::size_t capacity) : latency_(latency), capacity_(capacity) {}

  void wake(Alarm* consumer) override { consumer_ = consumer; }
  const T* front(Cycle now) const override {
    return !items_.empty() && items_.front().second <= now ? &items_.front().first : nullptr;
  }
  void pop(Cycle now) override {
    freed_.push_back(now);
    items_.pop_front();
  }
  Cycle next_visible() const override { return items_.empty() ? kNever : items_.front().second; }
  std::size_t size() const override { return items_.size(); }

  bool can_push(Cycle now) const override {
    std::size_t used = items_.size();
    for (const Cycle freed : freed_) used += freed == now ? 1 : 0;  // seen free a cycle later
    return used < capacity_;
  }
  void push(Cycle now, const T& item) override {
    assert(can_push(now));
    while (!freed_.empty() && freed_.front() < now) freed_.pop_front();
    items_.emplace_back(item, now + latency_);
    ++pushed;
    if (consumer_ != nullptr) consumer_->request(now + latency_);
  }
  unsigned latency() const override { return latency_; }

  std::uint64_t pushed = 0;

 private:
  unsigned latency_;
  std::size_t capacity_;
  std::deque<std::pair<T, Cycle>> items_;
  std::deque<Cycle> freed_;
  Alarm* consumer_ = nullptr;
};

}  // namespace grtx::modules
