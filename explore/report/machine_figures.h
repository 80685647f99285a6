// The cost model's figures of the machine that a run used, and the run's energy. A machine elaborates once a process,
// so each is asked in a child.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "grtx/explore/report/run_results.h"

namespace grtx::sim {

struct MachineFigures {
  /// As `grtx cost --json`; null when the configuration is none that this program can build.
  nlohmann::ordered_json cost;
  /// [{name, actions, basis, nanojoules: {low, central, high}}] of the parts that acted; empty without a run.
  nlohmann::ordered_json energy;
  std::string problem;  ///< why there are none
};

/// config: resolved, key -> value. design: baseline, sw, hw or grtx. accel, pop_test, layout, levels: of the trace,
/// decide on sphere units, on what a stack entry holds, on what reads nodes and on rays in the space of objects; "": as
/// by default. statistics: of the run; empty: no energy. bins: checkpoint bins of a ray; "": two buffers.
MachineFigures machine_figures(const nlohmann::ordered_json& config, const std::string& design,
                               const std::string& accel, const std::string& pop_test, const std::string& layout,
                               const std::string& levels, const nlohmann::ordered_json& statistics,
                               const std::string& bins = "");

}  // namespace grtx::sim
