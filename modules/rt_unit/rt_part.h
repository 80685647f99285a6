// What the RT unit's netlist asks of each of its parts, whoever made it.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <systemc>

#include "grtx/base/strong.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/messages/touch_if.h"

namespace grtx::modules {

/// A part does its work when the netlist calls its stages, in the order that RtUnit::run_stages states; it reaches its
/// neighbours through ports.
class RtPart : public sc_core::sc_module {
 public:
  /// Nothing inside: no request and no response under way. Links are not looked at.
  virtual bool idle() const = 0;
  /// Grows with all that the part does; for a watchdog.
  virtual std::uint64_t progress() const = 0;
  /// Adds counts that no unit of the project's has; what such a unit has, too, its interface's counters() gives.
  virtual void count(OwnCounts& /*own*/) const {}
  virtual Inventory inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;
  /// Another launch follows (Clocked::restart()); nothing is inside.
  virtual void restart() {}

 protected:
  explicit RtPart(const sc_core::sc_module_name& name) : sc_module(name) {}
};

/// A part with a port of the memory system: a client of the L1.
class RtMemoryPart : public RtPart {
 public:
  TouchPort<touch_if> touch_cache{"touch_cache"};  ///< the L1, for events without time

  /// Has functional entries beside its timed ones, which sampled runs need.
  virtual bool has_touch() const { return false; }
  /// In a sampled run: the cycle whose stages are called now.
  void set_touch_now(Cycle now) { touch_now_ = now; }

  /// Takes at most one response.
  virtual void respond(Cycle now) = 0;
  /// Sends at most one request.
  virtual void issue(Cycle now) = 0;
  /// Has work in the next cycle, whatever arrives.
  virtual bool busy() const = 0;

 protected:
  using RtPart::RtPart;
  Cycle touch_now() const { return touch_now_; }

 private:
  Cycle touch_now_ = 0;
};

}  // namespace grtx::modules
