// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/plan_machine.h"

#include <fmt/format.h>

#include <filesystem>
#include <set>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/experiment/machine.h"

namespace grtx::experiment {
namespace {

explore::PlanMachine plan_machine(const std::string& machine, const std::string& base,
                                  std::vector<std::string>& files) {
  ChosenMachine chosen = choose_machine({.machine = machine, .config = base});
  files.insert(files.end(), chosen.files.begin(), chosen.files.end());
  return {machine_name(machine), machine.ends_with(".toml") ? std::filesystem::absolute(machine).string() : machine,
          std::move(chosen.config), chosen.rivals, std::move(chosen.tracer)};
}

}  // namespace

std::vector<std::string> put_on_machine(explore::SweepPlan& plan, const std::optional<std::string>& machine) {
  std::vector<std::string> files;
  const std::string own = plan.machine_asked.empty() ? kDefaultMachine : plan.machine_asked;
  plan.machine = plan_machine(machine.value_or(own), plan.base, files);
  std::set<std::string> names;
  for (const auto& [text, varied] : plan.varied_machines) {
    try {
      plan.machines[text] = plan_machine(varied.option, plan.base, files);
    } catch (const Error& error) {
      throw Error(plan.path, varied.place, fmt::format("machine: {}", error.what()));
    }
    if (!names.insert(plan.machines[text].name).second) {
      throw Error(plan.path, varied.place, fmt::format("machine: two are called '{}'", plan.machines[text].name));
    }
  }
  return files;
}

}  // namespace grtx::experiment
