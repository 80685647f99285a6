// SPDX-License-Identifier: Apache-2.0
// Test fixture for SystemC modules: a fresh simulation context for every test, 1 fs resolution, warnings are failures.
// Also a clocked process for mocks, and running a clock domain for a number of cycles.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <systemc>
#include <utility>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/link_if.h"

namespace grtx::modules {

/// A new design begins: everything of the previous one must have been destroyed.
struct FreshContext {
  FreshContext() {
    sc_core::sc_curr_simcontext = new sc_core::sc_simcontext;
    sc_core::sc_default_global_context = sc_core::sc_curr_simcontext;
    set_time_resolution_to_fs();
  }
};

/// SystemC elaborates once per context, so each test gets a context of its own. The previous one is leaked on purpose:
/// destroying it is not supported by the kernel. Modules are locals of the test body or members of a derived fixture,
/// so they die while their context is still the current one.
class SystemCTest : public ::testing::Test {
 protected:
  SystemCTest() {
    sc_core::sc_report_handler::set_handler(&SystemCTest::report);
    fresh_context();
  }
  ~SystemCTest() override { sc_core::sc_report_handler::set_handler(&sc_core::sc_report_handler::default_handler); }

  static void fresh_context() { FreshContext(); }
  /// Runs until the domain has passed `cycles` more of its periods, whether they tick or are skipped.
  static void run(const ClockDomain& clock, Cycle cycles) {
    sc_core::sc_start(sc_core::sc_time::from_value(cycles * clock.period_fs()));
  }
  /// Runs until nothing is scheduled any more, at most `cycles` periods of `clock`; true when it went quiet.
  static bool run_until_quiet(const ClockDomain& clock, Cycle cycles) {
    const sc_core::sc_time end = sc_core::sc_time_stamp() + sc_core::sc_time::from_value(cycles * clock.period_fs());
    while (sc_core::sc_pending_activity() && sc_core::sc_time_stamp() < end) {
      sc_core::sc_start(std::min(sc_core::sc_time_to_pending_activity(), end - sc_core::sc_time_stamp()));
    }
    return !sc_core::sc_pending_activity();
  }

 private:
  static void report(const sc_core::sc_report& report, const sc_core::sc_actions& actions) {
    if (report.get_severity() == sc_core::SC_WARNING) {
      ADD_FAILURE() << "SystemC warning: " << report.what();
      return;
    }
    sc_core::sc_report_handler::default_handler(report, actions);
  }
};

/// Ends elaboration: ports know what they are bound to. No time passes.
inline void elaborate() {
  auto* const begun = new sc_core::sc_event;  // so that the kernel has something to do; leaked with its context
  begun->notify(sc_core::SC_ZERO_TIME);
  sc_core::sc_start(sc_core::SC_ZERO_TIME);
}

/// A clocked process made from a function: `body(now)` runs on every tick of the domain. Mocks are built from it; they
/// have the links that they read from watched.
class TickProcess final : public ClockedModule {
 public:
  using SC_CURRENT_USER_MODULE = TickProcess;  // SC_HAS_PROCESS, which SystemC 3 deprecates
  TickProcess(const sc_core::sc_module_name& name, ClockDomain& clock, std::function<void(Cycle)> body)
      : ClockedModule(name, clock), body_(std::move(body)) {
    SC_METHOD(on_tick);
    sensitive << clock_.tick();
    dont_initialize();
  }

  /// The domain ticks when something arrives on the link.
  template <typename T>
  void watch(link_in_if<T>& link) {
    link.wake(&alarm_);
  }

 private:
  Cycle tick(Cycle) override { return kNever; }
  void on_tick() { body_(clock_.cycle()); }

  std::function<void(Cycle)> body_;
};

}  // namespace grtx::modules
