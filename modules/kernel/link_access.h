// SPDX-License-Identifier: Apache-2.0
// Fast access to the channel bound to a port: the project's Link without virtual calls, any other channel through its
// interface. Construct these from a port at the end of elaboration.
#pragma once

#include <cstddef>
#include <cstdint>

#include "grtx/modules/kernel/link.h"
#include "grtx/modules/kernel/link_if.h"

namespace grtx::modules {

/// The consumer's side of a bound port; link_in_if states what the calls mean.
template <typename T>
class LinkReader {
 public:
  LinkReader() = default;
  explicit LinkReader(link_in_if<T>* link) : own_(dynamic_cast<Link<T>*>(link)), any_(link) {}
  LinkReader(Link<T>& link) : own_(&link), any_(&link) {}  // NOLINT: implicit conversion intended
  /// Whether a channel is bound.
  explicit operator bool() const { return any_ != nullptr; }

  void wake(Alarm* consumer) const { any_->wake(consumer); }
  bool announce(std::uint64_t* word, unsigned bit) const { return any_->announce(word, bit); }
  const T* front(Cycle now) const {
    if (own_ != nullptr) [[likely]]
      return own_->front(now);
    return any_->front(now);
  }
  void pop(Cycle now) const {
    if (own_ != nullptr) [[likely]]
      return own_->pop(now);
    any_->pop(now);
  }
  Cycle next_visible() const {
    if (own_ != nullptr) [[likely]]
      return own_->next_visible();
    return any_->next_visible();
  }
  std::size_t size() const { return own_ != nullptr ? own_->size() : any_->size(); }
  bool empty() const { return size() == 0; }

 private:
  Link<T>* own_ = nullptr;
  link_in_if<T>* any_ = nullptr;
};

/// The producer's side of a bound port; link_out_if states what the calls mean.
template <typename T>
class LinkWriter {
 public:
  LinkWriter() = default;
  explicit LinkWriter(link_out_if<T>* link) : own_(dynamic_cast<Link<T>*>(link)), any_(link) {}
  LinkWriter(Link<T>& link) : own_(&link), any_(&link) {}  // NOLINT: implicit conversion intended
  explicit operator bool() const { return any_ != nullptr; }

  bool can_push(Cycle now) const {
    if (own_ != nullptr) [[likely]]
      return own_->can_push(now);
    return any_->can_push(now);
  }
  void push(Cycle now, const T& item) const {
    if (own_ != nullptr) [[likely]]
      return own_->push(now, item);
    any_->push(now, item);
  }
  /// push() if there is room; returns whether there was.
  bool try_push(Cycle now, const T& item) const {
    if (own_ != nullptr) [[likely]]
      return own_->try_push(now, item);
    if (!any_->can_push(now)) return false;
    any_->push(now, item);
    return true;
  }
  unsigned latency() const { return any_->latency(); }

 private:
  Link<T>* own_ = nullptr;
  link_out_if<T>* any_ = nullptr;
};

/// Reader or writer of a port; tests false if the port is unbound.
template <typename T, int N, sc_core::sc_port_policy P>
LinkReader<T> reader_of(sc_core::sc_port<link_in_if<T>, N, P>& port) {
  return LinkReader<T>(port.size() > 0 ? port.operator->() : nullptr);
}
template <typename T, int N, sc_core::sc_port_policy P>
LinkWriter<T> writer_of(sc_core::sc_port<link_out_if<T>, N, P>& port) {
  return LinkWriter<T>(port.size() > 0 ? port.operator->() : nullptr);
}

}  // namespace grtx::modules
