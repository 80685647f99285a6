// How a run ends whose unit has broken the contract of its interface: with a report of a type of its own that names the
// unit. Units of others can do so; a trace cannot.
#pragma once

#include <stdexcept>
#include <string>
#include <systemc>

namespace grtx::modules {

inline constexpr const char* kUnitReport = "/grtx/unit";

/// unit: its name in the hierarchy.
[[noreturn]] inline void unit_fault(const std::string& unit, const std::string& rule) {
  SC_REPORT_ERROR(kUnitReport, (unit + ": " + rule).c_str());
  throw std::runtime_error(rule);  // where reports are told not to throw
}

/// What a part throws that knows what is wrong, to one that knows who was called.
struct WrongAnswer {
  std::string rule;
};

}  // namespace grtx::modules
