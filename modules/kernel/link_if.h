// What a module sees of a link: its producer's side and its consumer's side, each an interface of its own. Link<T> is
// the project's implementation; any channel that keeps these contracts can stand in its place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <systemc>

#include "grtx/base/strong.h"

namespace grtx::modules {

class Alarm;

/// The producer's side. There is one producer. An item that is pushed in cycle c becomes visible to the consumer in
/// cycle c + latency() or later, in the order of the pushes.
template <typename T>
class link_out_if : public virtual sc_core::sc_interface {
 public:
  /// Whether push() may be called in cycle `now`. Must not depend on whether the consumer has run in this very cycle:
  /// space that is freed in cycle c counts from c + 1 on.
  virtual bool can_push(Cycle now) const = 0;
  /// Only when can_push(now). Sets the consumer's alarm to the cycle in which the item becomes visible.
  virtual void push(Cycle now, const T& item) = 0;
  /// Cycles, at least 1.
  virtual unsigned latency() const = 0;
  /// Whether push() may be called ahead of its cycle `now`, in the order of these: the consumer takes every item in the
  /// cycle in which it becomes visible, so there is always room.
  virtual bool takes_ahead() const { return false; }
};

/// The consumer's side. There is one consumer.
template <typename T>
class link_in_if : public virtual sc_core::sc_interface {
 public:
  /// Names the alarm that is set when an item is on its way. Called once, before the simulation starts.
  virtual void wake(Alarm* consumer) = 0;
  /// Oldest item if it has arrived by cycle `now`, else nullptr. Valid until it is popped.
  virtual const T* front(Cycle now) const = 0;
  /// Takes the item that front(now) shows.
  virtual void pop(Cycle now) = 0;
  /// Cycle in which the oldest item is, or becomes, visible; kNever when there is none.
  virtual Cycle next_visible() const = 0;
  /// Items sent and not taken, visible or not.
  virtual std::size_t size() const = 0;
  bool empty() const { return size() == 0; }
  /// From now on the link sets this bit of the consumer's when next_visible() is no longer kNever, so that the consumer
  /// knows the few of its many links that hold something. Returns false when the link does not do that.
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
