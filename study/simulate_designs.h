// Simulates the traces of a comparison, each in a child process, and chooses the mode where none is named.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"
#include "grtx/study/design_comparison.h"
#include "grtx/study/trace_designs.h"

namespace grtx::sim {

/// What a run takes that names no mode: windows where they pay, which a line on stderr says. All designs have the same
/// rays.
SimulationMode unnamed_mode(const TracedDesigns& traced, const DesignComparison& comparison, const GpuConfig& config,
                            const WindowOptions& windows);

struct DesignSimulation {
  GpuConfig config;
  SimulationMode mode = SimulationMode::cycle;
  WindowOptions windows;
  unsigned jobs = 0;  ///< at a time; 0: one a core, while there is memory for each
  bool quiet = false;
};

/// Each design's statistics document, with "violations" and "binding_bound".
std::map<std::string, nlohmann::ordered_json> simulate_designs(const TracedDesigns& traced,
                                                               const DesignComparison& comparison,
                                                               const DesignSimulation& simulation);

}  // namespace grtx::sim
