// SPDX-License-Identifier: Apache-2.0
#include "grtx/view/report/machine_figures.h"

#include <optional>
#include <vector>

#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/lab/cost/cost_report.h"
#include "grtx/lab/cost/run_energy.h"
#include "grtx/lab/cost/run_machine.h"
#include "grtx/lab/sweep/points.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/machine.h"

namespace grtx::view {
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
  for (const lab::EnergyPart& part :
       lab::run_energy(value, config, inventories, lab::CostOptions(), lab::EnergyOptions())) {
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

MachineFigures machine_figures(const ordered_json& config, const ordered_json& inputs, const ordered_json& statistics,
                               const std::string& where) {
  MachineFigures figures;
  figures.energy = ordered_json::array();
  try {
    const sim::GpuConfig machine = lab::config_from(config);
    const sim::MachineUse use = lab::machine_of_run(inputs, where);
    ChildProcess child("cost of " + use.design, [&] {
      const std::vector<modules::Inventory> inventories = sim::machine_inventory(machine, use);
      ordered_json result;
      result["cost"] = lab::cost_json(lab::machine_cost(machine, use.design, inventories, lab::CostOptions()));
      result["energy"] = statistics.empty() ? ordered_json::array() : energy_of(statistics, machine, inventories);
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

}  // namespace grtx::view
