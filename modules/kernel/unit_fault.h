// SPDX-License-Identifier: Apache-2.0
// Ends a run in which a unit broke the contract of its interface, with a SystemC report that names the unit. Caused by
// user-supplied units only, never by a trace.
#pragma once

#include <stdexcept>
#include <string>
#include <systemc>

#include "grtx/modules/kernel/wrong_answer.h"

namespace grtx::modules {

inline constexpr const char* kUnitReport = "/grtx/unit";

/// Report type for an Error that a unit has thrown: the kernel keeps an exception's text, but not its type.
inline constexpr const char* kInputReport = "/grtx/input";

/// unit: its name in the hierarchy.
[[noreturn]] inline void unit_fault(const std::string& unit, const std::string& rule) {
  SC_REPORT_ERROR(kUnitReport, (unit + ": " + rule).c_str());
  throw std::runtime_error(rule);  // if reports are configured not to throw
}

}  // namespace grtx::modules
