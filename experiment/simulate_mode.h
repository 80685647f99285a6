// SPDX-License-Identifier: Apache-2.0
// Simulates a trace in a given mode.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/rtl_tlm/estimate/estimated_result.h"
#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"

namespace grtx::experiment {

/// simulation: options of mode cycle. windows: options of mode windows. In cycle mode the result is exact
/// (estimate.whole).
sim::EstimatedResult simulate_in_mode(sim::SimulationMode mode, const std::string& trace, const sim::GpuConfig& config,
                                      const sim::SimulationOptions& simulation, const sim::WindowOptions& windows);

/// Says on stderr what simulating takes if that is more than a minute. visits: of nodes, in all traces. jobs: traces
/// that are simulated at a time.
void say_simulation_time(const std::string& command, sim::SimulationMode mode, std::uint64_t visits, double share,
                         std::uint64_t bytes, unsigned jobs);

/// Memory of one simulation, without decoded groups.
inline constexpr std::uint64_t kMachineBytes = std::uint64_t{512} << 20;

}  // namespace grtx::experiment
