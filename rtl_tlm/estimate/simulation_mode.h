// The clocks that a whole trace can be run with, by name.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "grtx/base/named_enum.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace grtx::sim {

enum class SimulationMode : std::uint8_t {
  cycle,   ///< every module, cycle by cycle, in SystemC
  fast,    ///< loosely timed (estimate/fast); no waveforms, timelines or cycles by pixel
  sampled  ///< estimated from a share of the warps, which one of the others simulates (estimate/sampled)
};
constexpr auto enum_names(SimulationMode) {
  using enum SimulationMode;
  return std::to_array<EnumName<SimulationMode>>({{cycle, "cycle"}, {fast, "fast"}, {sampled, "sampled"}});
}

/// simulate() with the engine of that mode: cycle or fast.
SimulationResult simulate(const std::string& trace_path, const GpuConfig& config, const SimulationOptions& options,
                          SimulationMode mode);

}  // namespace grtx::sim
