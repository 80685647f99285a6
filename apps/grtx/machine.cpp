// SPDX-License-Identifier: Apache-2.0
// grtx machine: what a machine resolves to.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/base/json.h"
#include "grtx/experiment/machine.h"
#include "grtx/experiment/machine_keys.h"
#include "grtx/explore/sweep/designs.h"

namespace grtx::apps {
namespace {

std::string text_of(const nlohmann::ordered_json& value) {
  return value.is_string() ? value.get<std::string>() : json_text(value);
}

void print_text(const experiment::MachineKeys& machine) {
  for (const experiment::MachineKey& key : machine.keys) {
    const std::string source = key.source + (key.confidence.empty() ? "" : fmt::format(" [{}]", key.confidence));
    const std::string value = !key.set ? "not set" : text_of(key.value) + (key.unit.empty() ? "" : " " + key.unit);
    const std::string line = fmt::format("{:<31} {:<17} {:<20} {}", key.name, value, key.from, source);
    fmt::print("{}\n", line.substr(0, line.find_last_not_of(' ') + 1));
  }
  fmt::print("\n");
  for (const experiment::MachineFigure& figure : machine.figures) {
    fmt::print("{:<31} {:<17} from {}\n", figure.name, fmt::format("{:.6g} {}", figure.value, figure.unit),
               figure.follows);
  }
}

nlohmann::ordered_json json_of(const experiment::MachineKeys& machine, const std::string& name) {
  nlohmann::ordered_json json = json_document("machine");
  json["machine"] = name;
  for (const experiment::MachineKey& key : machine.keys) {
    json["keys"][key.name] = {{"value", key.value},
                              {"unit", key.unit},
                              {"from", key.from},
                              {"source", key.source},
                              {"confidence", key.confidence}};
  }
  for (const experiment::MachineFigure& figure : machine.figures) {
    json["figures"][figure.name] = {{"value", figure.value}, {"unit", figure.unit}, {"follows", figure.follows}};
  }
  return json;
}

int machine(const experiment::MachineChoice& options, bool as_json) {
  const experiment::MachineKeys keys = experiment::machine_keys(options);
  if (as_json) {
    print_json(json_of(keys, options.machine));
  } else {
    print_text(keys);
  }
  return 0;
}

}  // namespace

void add_machine(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<experiment::MachineChoice>();
  CLI::App* command = make_command(app, common, "machine", "Shows what a machine resolves to, key by key, and why",
                                   [options, &common] { return machine(*options, common.json); });
  command->add_option("MACHINE", options->machine, "Name of a machine, or a file .toml of your own");
  command->add_option("--config", options->config, "Configuration file: what differs from the machine (default: none)")
      ->type_name(kInputFile);
  command
      ->add_option("--design", options->design,
                   "Design whose own keys are set: its units and their sizes, after the file, before --set (default: "
                   "none)")
      ->check(one_of(explore::design_names()));
  command->add_option("--set", options->settings, "key=value, after the file; may be repeated (default: none)")
      ->allow_extra_args(false);
}

}  // namespace grtx::apps
