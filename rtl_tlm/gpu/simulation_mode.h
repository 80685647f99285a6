// SPDX-License-Identifier: Apache-2.0
// The ways to run a trace, by name.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/base/declare/named_enum.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

/// All modes simulate the same machine.
enum class SimulationMode : std::uint8_t {
  cycle,   ///< every event takes time
  windows  ///< only windows of the trace are simulated (estimate/windows)
};
constexpr auto enum_names(SimulationMode) { return names_in_order<SimulationMode>({"cycle", "windows"}); }

/// Error text for the name of a removed mode; "" for any other name.
std::string gone_mode(const std::string& name);

/// A key that a mode refuses, and why; an empty key: none.
struct Unmodelled {
  std::string key;
  std::string rule;
  explicit operator bool() const { return !key.empty(); }
};
/// In windows mode the first key that selects a unit in SystemVerilog, which is compared on whole traces, or a DRAM
/// model other than the built-in one.
Unmodelled unmodelled(const GpuConfig& config, SimulationMode mode);
/// Throws Error for such a key.
void check_mode(const GpuConfig& config, SimulationMode mode);

}  // namespace grtx::sim
