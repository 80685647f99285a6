// Simulates a trace in a given mode.
#pragma once

#include <string>

#include "grtx/rtl_tlm/estimate/sampled_simulation.h"
#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"

namespace grtx::sim {

/// simulation: options of modes cycle and sampled. windows: options of mode windows; sampled also uses its
/// target_error. In cycle mode the result is exact (estimate.whole).
SampledResult simulate_in_mode(SimulationMode mode, const std::string& trace, const GpuConfig& config,
                               const SimulationOptions& simulation, const WindowOptions& windows);

}  // namespace grtx::sim
