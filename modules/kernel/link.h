// SPDX-License-Identifier: Apache-2.0
// A registered link between two modules: one producer, one consumer, latency >= 1 cycle, finite capacity.
// Items sent in cycle c are visible from c + latency; space freed in cycle c is visible to the producer from c + 1.
// So results do not depend on the order in which producer and consumer are called within a cycle.
//
// Modules access links through ports of link_in_if and link_out_if (link_if.h), in hot loops through LinkReader and
// LinkWriter (link_access.h). Tools find links by name in the SystemC hierarchy (LinkObject).
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <systemc>
#include <vector>

#include "grtx/base/strong.h"
#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/link_if.h"

namespace grtx::modules {

/// A link in the SystemC hierarchy, independent of its message type; found by sc_find_object() and get_child_objects().
class LinkObject : public sc_core::sc_object, public Restarted {
 public:
  const char* kind() const override { return "grtx_link"; }
  /// Items sent and not taken, visible or not.
  virtual std::size_t size() const = 0;
  virtual std::size_t capacity() const = 0;
  /// Cycles, at least 1.
  virtual unsigned latency() const = 0;
  /// Items sent since the launch began.
  virtual std::uint64_t pushed() const = 0;

 protected:
  /// Silently replaces dots in the name and makes it unique: the kernel would warn, which ends runs that treat warnings
  /// as errors.
  explicit LinkObject(const std::string& name) : sc_object(free_name(name).c_str()) {}

  // Checks of what a unit may ask of a link. No asserts: a user's release build has none, and this is a user's code.
  void require(bool holds, const char* rule) const {
    if (!holds) [[unlikely]]
      refuse(rule);
  }
  [[noreturn, gnu::cold]] void refuse(const char* rule) const;

 private:
  static std::string free_name(std::string name) {
    std::replace(name.begin(), name.end(), '.', '_');
    return sc_core::sc_gen_unique_name(name.c_str(), true);
  }
};

// LinkObject is a virtual base, like sc_interface: it is placed after the members, so that the members that consumers
// poll stay in one cache line of the host.
template <typename T>
class alignas(64) Link final : public link_in_if<T>, public link_out_if<T>, public virtual LinkObject {
 public:
  /// name: within the module under construction, as for a port.
  Link(const std::string& name, unsigned latency, std::size_t capacity)
      : LinkObject(name), latency_(latency), capacity_(static_cast<std::uint32_t>(capacity)), slots_(capacity) {
    require(latency >= 1, "the latency of a link is one cycle at least");
    require(capacity >= 1 && capacity <= ~std::uint32_t{0},
            "a link has room for one item at least, and for 2^32 at most");
  }

  /// Registers the consumer's alarm; every push sets it to the cycle in which the item becomes visible. The link
  /// restarts with the consumer's clock domain.
  void wake(Alarm* consumer) override {
    if (consumer_ == nullptr && consumer != nullptr) consumer->restarts(*this);
    consumer_ = consumer;
  }
  bool announce(std::uint64_t* word, unsigned bit) override {
    announced_ = word;
    announced_bit_ = std::uint64_t{1} << bit;
    return true;
  }

  // Producer side.
  bool can_push(Cycle now) const override { return occupied(now) < capacity_; }
  std::size_t space(Cycle now) const { return capacity_ - occupied(now); }
  void push(Cycle now, const T& item) override { require(try_push(now, item), "push() into a full link"); }
  /// push() if there is room; returns whether there was.
  bool try_push(Cycle now, const T& item) {
    if (!can_push(now)) return false;
    slots_[tail_] = {item, now + latency_};
    tail_ = next(tail_);
    if (size_++ == 0) {
      visible_ = now + latency_;
      if (announced_ != nullptr) *announced_ |= announced_bit_;
    }
    ++pushed_;
    if (consumer_ != nullptr) consumer_->request(now + latency_);
    return true;
  }

  // Consumer side.
  /// Oldest item if it has arrived by `now`, else nullptr.
  const T* front(Cycle now) const override { return visible_ <= now ? &slots_[head_].item : nullptr; }
  void pop(Cycle now) override {
    require(front(now) != nullptr, "pop() of a link in which nothing is visible");
    if (last_pop_cycle_ != now) {
      last_pop_cycle_ = now;
      popped_this_cycle_ = 0;
    }
    ++popped_this_cycle_;
    head_ = next(head_);
    if (--size_ == 0) {
      head_ = tail_ = 0;  // reuses the same few cache lines of the host
      visible_ = kNever;
    } else {
      visible_ = slots_[head_].visible;
    }
  }
  /// Cycle at which the oldest item becomes visible; kNever when empty.
  Cycle next_visible() const override { return visible_; }

  /// The last item pushed if that was in cycle `now`, else nullptr. For observers that run after the cycle.
  const T* sent(Cycle now) const {
    const Slot& newest = slots_[tail_ == 0 ? capacity_ - 1 : tail_ - 1];
    return size_ != 0 && newest.visible == now + latency_ ? &newest.item : nullptr;
  }

  /// For another launch: back to the constructed state, without what was inside; keeps the consumer's alarm and
  /// announce() bit.
  void restart() override {
    last_pop_cycle_ = visible_ = kNever;
    head_ = tail_ = size_ = 0;
    pushed_ = 0;
    if (announced_ != nullptr) *announced_ &= ~announced_bit_;
  }

  bool empty() const { return size_ == 0; }
  std::size_t size() const override { return size_; }
  std::size_t capacity() const override { return capacity_; }
  unsigned latency() const override { return latency_; }
  std::uint64_t pushed() const override { return pushed_; }

 private:
  struct Slot {
    T item{};
    Cycle visible = 0;
  };
  std::uint32_t next(std::uint32_t i) const { return i + 1 == capacity_ ? 0 : i + 1; }
  // A slot popped in this cycle still counts: the producer sees it free from the next cycle on.
  std::uint32_t occupied(Cycle now) const { return size_ + (last_pop_cycle_ == now ? popped_this_cycle_ : 0); }

  // Consumers poll their links in most cycles and mostly find nothing; the poll reads one cache line of the host and
  // not the slots.
  Cycle visible_ = kNever;  ///< cycle in which the oldest item becomes visible
  std::uint32_t size_ = 0;
  std::uint32_t popped_this_cycle_ = 0;
  Cycle last_pop_cycle_ = kNever;
  std::uint32_t head_ = 0;
  std::uint32_t tail_ = 0;
  std::uint32_t latency_;
  std::uint32_t capacity_;
  std::vector<Slot> slots_;
  std::uint64_t pushed_ = 0;
  Alarm* consumer_ = nullptr;
  std::uint64_t* announced_ = nullptr;
  std::uint64_t announced_bit_ = 0;
};

}  // namespace grtx::modules
