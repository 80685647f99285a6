// SPDX-License-Identifier: Apache-2.0
// Base classes of the parts of an RT unit, with the functions that its netlist requires of each, user-supplied or not.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <systemc>

#include "grtx/base/strong.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"

namespace grtx::modules {

/// The netlist calls the stages of a part in the order of RtUnit::run_stages(). Parts reach their neighbours through
/// ports.
class RtPart : public sc_core::sc_module {
 public:
  /// Whether nothing is inside: no request and no pending response. Does not consider the links.
  virtual bool idle() const = 0;
  /// Grows whenever the part makes progress; for a watchdog.
  virtual std::uint64_t progress() const = 0;
  /// Adds counters of a user-defined part that the project's parts do not have; the common ones are returned by
  /// counters() of its interface.
  virtual void count(OwnCounts& /*own*/) const {}
  virtual Inventory inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;
  /// Prepares for another launch, and drops the part's contents (Clocked::restart()).
  virtual void restart() {}
  /// False while the stages of the part would do nothing if nothing arrived on its links: they are then not called.
  bool awake() const { return awake_; }

 protected:
  explicit RtPart(const sc_core::sc_module_name& name) : sc_module(name) {}
  explicit RtPart(const char* name) = delete;  ///< members would land in the module around it: see ClockedModule

  bool awake_ = true;  ///< a derived part may keep it up to date, which saves calls; true is always right
};

/// A part that is a client of the L1.
class RtMemoryPart : public RtPart {
 public:
  /// Receives at most one response.
  virtual void respond(Cycle now) = 0;
  /// Sends at most one request.
  virtual void issue(Cycle now) = 0;
  /// Whether there is work in the next cycle even if nothing arrives.
  virtual bool busy() const = 0;

 protected:
  using RtPart::RtPart;
};

}  // namespace grtx::modules
