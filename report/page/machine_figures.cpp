// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/machine_figures.h"

#include <cmath>
#include <optional>
#include <vector>

#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/explore/cost/cost_report.h"
#include "grtx/explore/cost/run_energy.h"
#include "grtx/explore/cost/run_machine.h"
#include "grtx/explore/sweep/points.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/machine.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;

ordered_json energy_of(const ordered_json& statistics, const sim::GpuConfig& config,
                       const std::vector<modules::Inventory>& inventories) {
  const auto value = [&](const std::string& name) {
    const auto found = statistics.find(name);
    const bool counted = found != statistics.end() && found->at("value").is_number();
    return counted ? std::optional(found->at("value").get<double>()) : std::nullopt;
  };
  ordered_json energy = ordered_json::array();
  for (const explore::EnergyPart& part :
       explore::run_energy(value, config, inventories, explore::CostOptions(), explore::EnergyOptions())) {
    if (part.actions == 0.0) continue;
    energy.push_back(
        {{"name", part.name},
         {"actions", part.actions},
         {"basis", part.basis},
         {"nanojoules",
          {{"low", part.nanojoules.low}, {"central", part.nanojoules.central}, {"high", part.nanojoules.high}}}});
  }
  return energy;
}

}  // namespace

double energy_nj(const DesignResult& design, const MachineFigures& machine) {
  if (const double recorded = design.value("gpu.energy_nj"); std::isfinite(recorded)) return recorded;
  if (machine.energy.empty()) return std::nan("");
  double sum = 0.0;
  for (const ordered_json& part : machine.energy) sum += part.at("nanojoules").at("central").get<double>();
  return sum;
}

double chip_mm2(const MachineFigures& machine) {
  if (machine.cost.is_null()) return std::nan("");
  return machine.cost.at("tree").at("area_mm2").at("central").get<double>();
}

MachineFigures machine_figures(const ordered_json& config, const ordered_json& inputs, const ordered_json& statistics,
                               const std::string& where) {
  MachineFigures figures;
  figures.energy = ordered_json::array();
  try {
    const sim::GpuConfig machine = explore::config_from(config);
    const sim::MachineUse use = explore::machine_of_run(inputs, where);
    // Estimates have the energy of groups, and no counters to price parts by.
    const bool has_parts = !statistics.empty() && inputs.value("mode", "") != name_of(sim::SimulationMode::windows);
    ChildProcess child("cost of " + use.design, [&] {
      const std::vector<modules::Inventory> inventories = sim::machine_inventory(machine, use);
      ordered_json result;
      result["cost"] =
          explore::cost_json(explore::machine_cost(machine, use.design, inventories, explore::CostOptions()));
      result["energy"] = has_parts ? energy_of(statistics, machine, inventories) : ordered_json::array();
      return json_text(result);
    });
    const ordered_json result = parse_json(child.result(), "cost");
    figures.cost = result.at("cost");
    figures.energy = result.at("energy");
  } catch (const Error& error) {  // e.g. a configuration of another version; the rest of the report is still valid
    figures.problem = error.what();
  }
  return figures;
}

}  // namespace grtx::report
