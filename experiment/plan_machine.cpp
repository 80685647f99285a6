// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/plan_machine.h"

#include <filesystem>
#include <utility>

#include "grtx/experiment/machine.h"

namespace grtx::experiment {

std::vector<std::string> put_on_machine(explore::SweepPlan& plan, const std::string& machine) {
  plan.base_machine.name = machine_name(machine);
  plan.base_machine.option = machine.ends_with(".toml") ? std::filesystem::absolute(machine).string() : machine;
  ChosenMachine chosen = choose_machine({.machine = machine, .config = plan.base});
  plan.machine = std::move(chosen.config);
  plan.rivals = chosen.rivals;
  plan.tracer = std::move(chosen.tracer);
  return chosen.files;
}

}  // namespace grtx::experiment
