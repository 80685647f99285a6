// A registered link (link.h) whose producer and consumer run on different threads. Both sides see exactly what they
// would see on a single thread.
#pragma once

#include <atomic>
#include <cassert>
#include <cstddef>
#include <vector>

#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/kernel/thread_progress.h"

namespace grtx::modules {

/// The consumer sees the items of its last collect(); its thread processes a cycle only when all items that can be
/// visible in it have been sent (ClockThreads). Space is exact, too: a place that was emptied in cycle c is free from
/// c + 1 on, whichever thread gets there first, because each place stores the cycle in which it was emptied. If the
/// link looks full, the producer waits until the consumer has reached the producer's cycle. A message moves only the
/// cache line of its place between threads: each place tells whether it holds an item, and the counts are private to
/// one thread each.
template <typename T>
class CrossingLink final : public link_in_if<T>, public link_out_if<T> {
 public:
  /// consumer: progress of the consumer's thread. ahead: number of items that may be sent ahead of their cycle; if not
  /// 0, the consumer must take every item in the cycle in which it becomes visible.
  CrossingLink(unsigned latency, std::size_t capacity, const ThreadProgress& consumer, std::size_t ahead = 0)
      : latency_(latency), capacity_(capacity), ahead_(ahead), consumer_(consumer), places_(capacity + 2 * ahead) {
    assert(latency >= 1 && capacity >= 1);
  }

  // Producer side.
  bool can_push(Cycle now) const override {
    if (ahead_ != 0 || room(now)) return true;
    consumer_.wait_for(now);
    return room(now);
  }
  /// Whether can_push(now) would return without waiting.
  bool knows_room(Cycle now) const { return ahead_ != 0 || room(now) || consumer_.cycles() >= now; }
  bool takes_ahead() const override { return ahead_ != 0; }
  void push(Cycle now, const T& item) override {
    Place& place = places_[sent_ % places_.size()];
    [[maybe_unused]] const Cycle left = place.left.load(std::memory_order_acquire);
    assert(left != kNever);
    place.item = item;
    place.left.store(kNever, std::memory_order_relaxed);
    place.visible.store(now + latency_, std::memory_order_release);
    ++sent_;
  }
  std::uint64_t pushed() const { return sent_; }

  // Consumer side.
  void wake(Alarm* consumer) override { alarm_ = consumer; }
  /// Registers newly sent items and sets the consumer's alarm. Called between two cycles.
  void collect() {
    const std::uint64_t before = collected_;
    while (collected_ - taken_ < places_.size() &&
           places_[collected_ % places_.size()].visible.load(std::memory_order_acquire) != kNever) {
      ++collected_;
    }
    if (collected_ == before) return;
    if (alarm_ != nullptr) {
      alarm_->request(places_[before % places_.size()].visible.load(std::memory_order_relaxed));
    }
    if (announced_ != nullptr) *announced_ |= announced_bit_;
  }
  bool announce(std::uint64_t* word, unsigned bit) override {
    announced_ = word;
    announced_bit_ = std::uint64_t{1} << bit;
    return true;
  }
  /// Items that collect() has registered so far.
  std::uint64_t collected() const { return collected_; }
  const T* front(Cycle now) const override {
    return next_visible() <= now ? &places_[taken_ % places_.size()].item : nullptr;
  }
  void pop(Cycle now) override {
    assert(front(now) != nullptr);
    Place& place = places_[taken_++ % places_.size()];
    place.visible.store(kNever, std::memory_order_relaxed);
    place.left.store(now, std::memory_order_release);
  }
  Cycle next_visible() const override {
    return taken_ != collected_ ? places_[taken_ % places_.size()].visible.load(std::memory_order_relaxed) : kNever;
  }

  /// Call only while neither thread works.
  std::size_t size() const override { return static_cast<std::size_t>(sent_ - taken_); }
  unsigned latency() const override { return latency_; }

 private:
  struct alignas(32) Place {
    T item{};
    std::atomic<Cycle> visible{kNever};  ///< cycle in which the item becomes visible; kNever if empty
    std::atomic<Cycle> left{0};          ///< cycle in which the last item was taken; kNever if occupied
  };
  // Whether the places known to be emptied before `now` leave room.
  bool room(Cycle now) const {
    while (sent_ - freed_ >= capacity_) {
      if (places_[freed_ % places_.size()].left.load(std::memory_order_acquire) >= now) return false;
      ++freed_;
    }
    return true;
  }

  unsigned latency_;
  std::size_t capacity_;
  std::size_t ahead_;
  const ThreadProgress& consumer_;
  std::vector<Place> places_;
  Alarm* alarm_ = nullptr;
  std::uint64_t* announced_ = nullptr;
  std::uint64_t announced_bit_ = 0;
  alignas(64) std::uint64_t sent_ = 0;   ///< by the producer
  mutable std::uint64_t freed_ = 0;      ///< items the producer knows to be taken
  alignas(64) std::uint64_t taken_ = 0;  ///< by the consumer
  std::uint64_t collected_ = 0;
};

}  // namespace grtx::modules
