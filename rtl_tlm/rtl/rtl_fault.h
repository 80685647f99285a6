// How a bridge ends a run whose block is wrong: a report of the kernel of its own type, which is no internal error.
#pragma once

#include <stdexcept>
#include <string>
#include <systemc>

namespace grtx::sim {

inline constexpr const char* kRtlReport = "/grtx/rtl";

/// unit: its name in the hierarchy. place: of what.
[[noreturn]] inline void rtl_fault(const char* unit, const std::string& place, const std::string& rule) {
  SC_REPORT_ERROR(kRtlReport, (std::string(unit) + " (RTL): " + place + ": " + rule).c_str());
  throw std::runtime_error(rule);  // where reports are told not to throw
}

}  // namespace grtx::sim
