// SPDX-License-Identifier: Apache-2.0
// Cost of the machine that a run used, and the run's energy. A process can elaborate only one machine, so each is
// computed in a child process.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "grtx/report/page/run_results.h"

namespace grtx::report {

struct MachineFigures {
  /// As `grtx cost --json`; null if this program cannot build the configuration.
  nlohmann::ordered_json cost;
  /// [{name, actions, basis, nanojoules: {low, central, high}}] for the parts with actions; empty without statistics.
  nlohmann::ordered_json energy;
  std::string problem;  ///< why cost and energy are missing; "" if they are not
};

/// Energy of a run in nJ: as recorded, else as computed; NaN if neither is there.
double energy_nj(const DesignResult& design, const MachineFigures& machine);
/// Central estimate of the chip's area; NaN without one.
double chip_mm2(const MachineFigures& machine);

/// config: resolved, key -> value. inputs: of the run, which determine the units of the machine. statistics: of the
/// run; empty: no energy. where: file named in `problem`.
MachineFigures machine_figures(const nlohmann::ordered_json& config, const nlohmann::ordered_json& inputs,
                               const nlohmann::ordered_json& statistics, const std::string& where);

}  // namespace grtx::report
