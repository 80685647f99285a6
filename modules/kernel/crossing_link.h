// A registered link (link.h) whose producer and consumer run on different threads. Whatever the threads do, both sides
// see what they would see on one.
#pragma once

#include <atomic>
#include <cassert>
#include <cstddef>
#include <vector>

#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/kernel/thread_progress.h"

namespace grtx::modules {

/// Where a thread finds what others have sent it.
class Inbox {
 public:
  /// Takes note of what has arrived: the consumer's alarm is set. By the consumer's thread, between two cycles.
  virtual void collect() = 0;

 protected:
  ~Inbox() = default;
};

/// The consumer sees items as of its last collect(): its thread works on a cycle only when all that can be visible in
/// it has been sent (ClockThreads). Space is exact too: an item taken in cycle c is free from c + 1 on, in whatever
/// order the threads come there, since each item remembers when it was taken. When the link looks full, the producer
/// waits until the consumer has come to its cycle.
template <typename T>
class CrossingLink final : public link_in_if<T>, public link_out_if<T>, public Inbox {
 public:
  /// consumer: its thread's. ahead: items that may be sent before their cycle, which needs a consumer that takes each
  /// item in the cycle in which it becomes visible; 0: none.
  CrossingLink(unsigned latency, std::size_t capacity, const ThreadProgress& consumer, Patience patience,
               std::size_t ahead = 0)
      : latency_(latency),
        capacity_(capacity),
        ahead_(ahead),
        consumer_(consumer),
        patience_(patience),
        slots_(capacity + 2 * ahead),
        taken_(capacity + 2 * ahead) {
    assert(latency >= 1 && capacity >= 1);
  }

  // Producer side.
  bool can_push(Cycle now) const override {
    if (ahead_ != 0 || room(now)) return true;
    consumer_.wait_for(now, patience_);
    return room(now);
  }
  bool takes_ahead() const override { return ahead_ != 0; }
  void push(Cycle now, const T& item) override {
    assert(sent_ - popped_.load(std::memory_order_relaxed) < slots_.size());
    slots_[sent_ % slots_.size()] = {item, now + latency_};
    pushed_.store(++sent_, std::memory_order_release);
  }
  std::uint64_t pushed() const { return pushed_.load(std::memory_order_acquire); }

  // Consumer side.
  void wake(Alarm* consumer) override { alarm_ = consumer; }
  void collect() override {
    const std::uint64_t arrived = pushed_.load(std::memory_order_acquire);
    if (arrived == collected_) return;
    if (alarm_ != nullptr) alarm_->request(slots_[collected_ % slots_.size()].visible);
    collected_ = arrived;
  }
  /// Items that collect() has seen so far.
  std::uint64_t collected() const { return collected_; }
  const T* front(Cycle now) const override {
    return next_visible() <= now ? &slots_[head_ % slots_.size()].item : nullptr;
  }
  void pop(Cycle now) override {
    assert(front(now) != nullptr);
    taken_[head_ % taken_.size()] = now;
    popped_.store(++head_, std::memory_order_release);
  }
  Cycle next_visible() const override { return head_ != collected_ ? slots_[head_ % slots_.size()].visible : kNever; }

  /// Exact while neither thread works.
  std::size_t size() const override {
    return static_cast<std::size_t>(pushed() - popped_.load(std::memory_order_acquire));
  }
  unsigned latency() const override { return latency_; }

 private:
  struct Slot {
    T item{};
    Cycle visible = 0;
  };
  // By what was taken before `now`, as far as is known.
  bool room(Cycle now) const {
    if (sent_ - freed_ >= capacity_) {
      const std::uint64_t popped = popped_.load(std::memory_order_acquire);
      while (freed_ < popped && taken_[freed_ % taken_.size()] < now) ++freed_;
    }
    return sent_ - freed_ < capacity_;
  }

  unsigned latency_;
  std::size_t capacity_;
  std::size_t ahead_;
  const ThreadProgress& consumer_;
  Patience patience_;
  std::vector<Slot> slots_;
  std::vector<Cycle> taken_;  ///< by slot: the cycle in which its item was taken
  Alarm* alarm_ = nullptr;
  // What each side writes lies in lines of the host's cache of its own.
  alignas(64) std::atomic<std::uint64_t> pushed_{0};
  std::uint64_t sent_ = 0;
  mutable std::uint64_t freed_ = 0;
  alignas(64) std::atomic<std::uint64_t> popped_{0};
  std::uint64_t head_ = 0;
  std::uint64_t collected_ = 0;
};

}  // namespace grtx::modules
