// SPDX-License-Identifier: Apache-2.0
// Ends a run in which an RTL block gave a wrong result, with a SystemC report of its own type.
#pragma once

#include <stdexcept>
#include <string>
#include <systemc>

namespace grtx::sim {

inline constexpr const char* kRtlReport = "/grtx/rtl";

/// unit: its name in the hierarchy. place: of the operation with the wrong result.
[[noreturn]] inline void rtl_fault(const char* unit, const std::string& place, const std::string& rule) {
  SC_REPORT_ERROR(kRtlReport, (std::string(unit) + " (RTL): " + place + ": " + rule).c_str());
  throw std::runtime_error(rule);  // if reports are configured not to throw
}

}  // namespace grtx::sim
