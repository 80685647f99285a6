// SPDX-License-Identifier: Apache-2.0
// The producer's and the consumer's interface of a link. Link<T> is the project's implementation; any channel that
// keeps these contracts can replace it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <systemc>

#include "grtx/base/strong.h"

namespace grtx::modules {

class Alarm;

/// The producer's side, for one producer. An item pushed in cycle c becomes visible to the consumer in cycle
/// c + latency() or later, in push order.
template <typename T>
class link_out_if : public virtual sc_core::sc_interface {
 public:
  /// Whether push() may be called in cycle `now`. Must not depend on whether the consumer has already run in this
  /// cycle: space freed in cycle c counts from c + 1 on.
  virtual bool can_push(Cycle now) const = 0;
  /// Requires can_push(now). Sets the consumer's alarm to the cycle in which the item becomes visible.
  virtual void push(Cycle now, const T& item) = 0;
  /// Cycles, at least 1.
  virtual unsigned latency() const = 0;
};

/// The consumer's side, for one consumer.
template <typename T>
class link_in_if : public virtual sc_core::sc_interface {
 public:
  /// Registers the alarm that is set when an item is sent. Called once, before the simulation starts.
  virtual void wake(Alarm* consumer) = 0;
  /// Oldest item if it is visible in cycle `now`, else nullptr. Valid until popped.
  virtual const T* front(Cycle now) const = 0;
  /// Removes the item that front(now) returns, which must exist.
  virtual void pop(Cycle now) = 0;
  /// Cycle in which the oldest item is, or becomes, visible; kNever when there is none.
  virtual Cycle next_visible() const = 0;
  /// Items sent and not taken, visible or not.
  virtual std::size_t size() const = 0;
  bool empty() const { return size() == 0; }
  /// From now on the link sets this bit in the consumer's word when it becomes non-empty (next_visible() != kNever), so
  /// that a consumer with many links polls only those that hold something. Returns false if not supported.
  virtual bool announce(std::uint64_t* /*word*/, unsigned /*bit*/) { return false; }
};

/// Ports of modules.
template <typename T>
using LinkIn = sc_core::sc_port<link_in_if<T>>;
template <typename T>
using LinkOut = sc_core::sc_port<link_out_if<T>>;
/// Ports that a configuration may leave unbound.
template <typename T>
using OptionalLinkIn = sc_core::sc_port<link_in_if<T>, 1, sc_core::SC_ZERO_OR_MORE_BOUND>;
template <typename T>
using OptionalLinkOut = sc_core::sc_port<link_out_if<T>, 1, sc_core::SC_ZERO_OR_MORE_BOUND>;

}  // namespace grtx::modules
