// The clocks that a whole trace can be run with, by name.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "grtx/rtl_tlm/gpu/mode_keys.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace grtx::sim {

inline constexpr std::array<std::string_view, 2> kSimulationModeNames = {"cycle", "fast"};

/// simulate() with the engine of that mode.
SimulationResult simulate(const std::string& trace_path, const GpuConfig& config, const SimulationOptions& options,
                          SimulationMode mode);

}  // namespace grtx::sim
