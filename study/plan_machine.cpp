// SPDX-License-Identifier: Apache-2.0
#include "grtx/study/plan_machine.h"

#include <filesystem>

#include "grtx/study/machine.h"

namespace grtx::study {

void put_on_machine(lab::SweepPlan& plan, const std::string& machine) {
  if (machine.empty()) return;
  plan.on.name = machine_name(machine);
  plan.on.option = machine.ends_with(".toml") ? std::filesystem::absolute(machine).string() : machine;
  plan.machine = load_machine_config(machine, plan.base, {});
  lab::Coordinates settings;
  for (const auto& [name, value] : machine_tracer(machine)) settings.emplace_back("tracer." + name, value);
  plan.settings.insert(plan.settings.begin(), settings.begin(), settings.end());
}

}  // namespace grtx::study
