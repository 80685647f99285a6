// A trace simulated in the mode that somebody names.
#pragma once

#include <string>

#include "grtx/rtl_tlm/estimate/sampled_simulation.h"
#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"

namespace grtx::sim {

/// windows: of mode `windows`; its target error is one of `sampled`, too. simulation: of the other modes. Of cycle mode
/// the estimate is the whole.
SampledResult simulate_in_mode(SimulationMode mode, const std::string& trace, const GpuConfig& config,
                               const SimulationOptions& simulation, const WindowOptions& windows);

}  // namespace grtx::sim
