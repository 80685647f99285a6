// SPDX-License-Identifier: Apache-2.0
#include "grtx/study/plan_machine.h"

#include <filesystem>
#include <utility>

#include "grtx/study/machine.h"

namespace grtx::study {

std::vector<std::string> put_on_machine(lab::SweepPlan& plan, const std::string& machine) {
  plan.on.name = machine_name(machine);
  plan.on.option = machine.ends_with(".toml") ? std::filesystem::absolute(machine).string() : machine;
  ChosenMachine chosen = choose_machine({.machine = machine, .config = plan.base});
  plan.machine = std::move(chosen.config);
  plan.rivals = chosen.rivals;
  plan.tracer = std::move(chosen.tracer);
  return chosen.files;
}

}  // namespace grtx::study
