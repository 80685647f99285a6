// The clocks that a whole trace can be run with, by name.
#pragma once

#include <string>

#include "grtx/rtl_tlm/gpu/mode_keys.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace grtx::sim {

/// simulate() with the engine of that mode: cycle or fast.
SimulationResult simulate(const std::string& trace_path, const GpuConfig& config, const SimulationOptions& options,
                          SimulationMode mode);

}  // namespace grtx::sim
