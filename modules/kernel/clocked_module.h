// SPDX-License-Identifier: Apache-2.0
// A clocked hardware unit: an sc_module that its clock domain calls in the cycles in which it has work.
#pragma once

#include <systemc>

#include "grtx/modules/kernel/clock_domain.h"

namespace grtx::modules {

/// Derived units take a `const sc_core::sc_module_name&` and hand it on. A name of another type would end its module
/// when this base is constructed, and the members would land in the module around it; so it does not compile. Derived
/// units implement tick() (see Clocked) and give the alarm to their input links: LinkReader::wake(&alarm_).
class ClockedModule : public sc_core::sc_module, public Clocked {
 public:
  using sc_core::sc_module::name;

 protected:
  /// clock must outlive the module.
  ClockedModule(const sc_core::sc_module_name& name, ClockDomain& clock)
      : sc_module(name), clock_(clock), alarm_(clock, *this) {}
  ClockedModule(const char* name, ClockDomain& clock) = delete;

  ClockDomain& clock_;
  Alarm alarm_;
};

}  // namespace grtx::modules
