// SPDX-License-Identifier: Apache-2.0
// Simulates a trace in a given mode.
#pragma once

#include <string>

#include "grtx/rtl_tlm/estimate/sampled_simulation.h"
#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"

namespace grtx::study {

/// simulation: options of modes cycle and sampled. windows: options of mode windows; sampled also uses its
/// target_error. In cycle mode the result is exact (estimate.whole).
sim::SampledResult simulate_in_mode(sim::SimulationMode mode, const std::string& trace, const sim::GpuConfig& config,
                                    const sim::SimulationOptions& simulation, const sim::WindowOptions& windows);

}  // namespace grtx::study
