// SPDX-License-Identifier: Apache-2.0
// Observes the model after every cycle of a window, from outside: modules have no code for it, and outside the window
// it causes no kernel activity.
#pragma once

#include <exception>
#include <string>
#include <systemc>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/rtl_tlm/observe/observe_options.h"

namespace grtx::sim {

/// Parses "A:B", "A:" or ":B". option: name of the option, for the Error that is thrown for anything else.
CycleWindow parse_window(const std::string& option, const std::string& text);

/// Sees the state that every module has at the end of a cycle.
class CycleObserver {
 public:
  virtual ~CycleObserver() = default;
  /// Called for each cycle of the window, in order, skipped ones included. The first call may be for the cycle before
  /// the window, which shows the state in which the window begins.
  virtual void sample(Cycle now) = 0;
  /// True if nothing will change before the next launch, so that sampling may pause.
  virtual bool rests() const { return false; }
};

/// Wakes in each cycle of the window, and a delta cycle later, when all modules have done their cycle, calls the
/// observer. Ticking a cycle that the clock would have skipped changes no result (ClockDomain).
class Observation final : public modules::ClockedModule {
 public:
  using SC_CURRENT_USER_MODULE = Observation;  // SC_HAS_PROCESS, which SystemC 3 deprecates
  /// observer must outlive it.
  Observation(const sc_core::sc_module_name& name, modules::ClockDomain& domain, const CycleWindow& window,
              CycleObserver& observer);
  /// The exception that the observer threw, if any.
  const std::exception_ptr& failure() const { return failure_; }

 private:
  Cycle tick(Cycle now) override;
  void restart(modules::Caches) override { begin(); }
  void begin() { alarm_.request(window_.first == 0 ? 0 : window_.first - 1); }
  void look();

  CycleWindow window_;
  CycleObserver& observer_;
  sc_core::sc_event settled_;
  std::exception_ptr failure_;
};

}  // namespace grtx::sim
