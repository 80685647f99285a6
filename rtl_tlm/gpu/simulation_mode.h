// SPDX-License-Identifier: Apache-2.0
// The ways to run a trace, by name.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/base/declare/named_enum.h"

namespace grtx::sim {

/// All modes simulate the same machine.
enum class SimulationMode : std::uint8_t {
  cycle,   ///< every event takes time
  windows  ///< only windows of the trace are simulated (estimate/windows)
};
constexpr auto enum_names(SimulationMode) { return names_in_order<SimulationMode>({"cycle", "windows"}); }

/// Error text for the name of a removed mode; "" for any other name.
std::string gone_mode(const std::string& name);

}  // namespace grtx::sim
