// SPDX-License-Identifier: Apache-2.0
// Simulates the traces of a comparison, each in a child process, and chooses the mode where none is named.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "grtx/experiment/design_comparison.h"
#include "grtx/experiment/trace_designs.h"
#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"

namespace grtx::experiment {

/// Mode of a run without --mode: windows if they save time (reported on stderr), else cycle. All designs have the same
/// rays.
sim::SimulationMode unnamed_mode(const TracedDesigns& traced, const DesignComparison& comparison,
                                 const sim::GpuConfig& config, const sim::WindowOptions& windows);

struct DesignSimulation {
  std::map<std::string, sim::GpuConfig> configs;  ///< by design
  sim::SimulationMode mode = sim::SimulationMode::cycle;
  sim::WindowOptions windows;
  unsigned jobs = 0;  ///< parallel simulations; 0: one per core, limited by free memory
  bool quiet = false;
};

/// Returns the statistics document of each design, with "violations" and "binding_bound".
std::map<std::string, nlohmann::ordered_json> simulate_designs(const TracedDesigns& traced,
                                                               const DesignComparison& comparison,
                                                               const DesignSimulation& simulation);

}  // namespace grtx::experiment
