// SPDX-License-Identifier: Apache-2.0
// Simulates the traces of a comparison on each machine, each in a child process, and chooses the mode where none is
// named.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/experiment/design_comparison.h"
#include "grtx/experiment/trace_designs.h"
#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"

namespace grtx::experiment {

/// The designs on one machine.
struct MachineSimulation {
  std::string name;  ///< "" for a single machine, which needs none
  const TracedDesigns* traced = nullptr;
  sim::GpuConfig machine;                         ///< without what designs bring
  std::map<std::string, sim::GpuConfig> configs;  ///< by design
};

/// Mode of a run without --mode: windows if they save time on each machine (reported on stderr), else cycle. All
/// designs have the same rays.
sim::SimulationMode unnamed_mode(const std::vector<MachineSimulation>& machines, const DesignComparison& comparison,
                                 const sim::WindowOptions& windows);

struct DesignSimulation {
  sim::SimulationMode mode = sim::SimulationMode::cycle;
  sim::WindowOptions windows;
  unsigned jobs = 0;  ///< parallel simulations; 0: one per core, limited by free memory
  bool quiet = false;
  bool latency = false;  ///< sim::SimulationOptions::latency
};

/// Returns for each machine the statistics document of each design, with "violations" and "binding_bound".
std::vector<std::map<std::string, nlohmann::ordered_json>> simulate_designs(
    const std::vector<MachineSimulation>& machines, const DesignComparison& comparison,
    const DesignSimulation& simulation);

}  // namespace grtx::experiment
