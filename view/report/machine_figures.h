// The cost model's figures of the machine that a run used, and the run's energy. A machine elaborates once a process,
// so each is asked in a child.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "grtx/view/report/run_results.h"

namespace grtx::sim {

struct MachineFigures {
  /// As `grtx cost --json`; null when the configuration is none that this program can build.
  nlohmann::ordered_json cost;
  /// [{name, actions, basis, nanojoules: {low, central, high}}] of the parts that acted; empty without a run.
  nlohmann::ordered_json energy;
  std::string problem;  ///< why there are none
};

/// config: resolved, key -> value. inputs: of the run, which say the units that it had. statistics: of the run; empty:
/// no energy. where: the file, for what is wrong in it.
MachineFigures machine_figures(const nlohmann::ordered_json& config, const nlohmann::ordered_json& inputs,
                               const nlohmann::ordered_json& statistics, const std::string& where);

}  // namespace grtx::sim
