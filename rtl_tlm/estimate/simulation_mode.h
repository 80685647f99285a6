// The clocks that a whole trace can be run with, by name.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "grtx/rtl_tlm/run/simulation.h"

namespace grtx::sim {

enum class SimulationMode : std::uint8_t {
  cycle,  ///< every module, cycle by cycle, in SystemC
  fast    ///< loosely timed (estimate/fast); no waveforms, timelines or cycles by pixel
};
inline constexpr std::array<std::string_view, 2> kSimulationModeNames = {"cycle", "fast"};

/// simulate() with the engine of that mode.
SimulationResult simulate(const std::string& trace_path, const GpuConfig& config, const SimulationOptions& options,
                          SimulationMode mode);

}  // namespace grtx::sim
