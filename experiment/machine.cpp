// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/machine.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"
#include "grtx/experiment/option_text.h"
#include "grtx/explore/sweep/designs.h"
#include "grtx/rtl_tlm/run/model_version.h"

namespace grtx::experiment {
namespace {

namespace fs = std::filesystem;

/// The options by name. Throws Error{file, "line N", rule} for one that the tracer has not, or that it would refuse.
std::map<std::string, std::string> checked(const sim::TracerTexts& texts) {
  std::map<std::string, std::string> options;
  for (const auto& [name, text] : texts) {
    const std::string line = fmt::format("line {}", text.place.line);
    std::vector<std::string> known;
    for (const TracerOptionName& option : tracer_option_names()) known.push_back(option.key);
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      throw Error(text.place.file, line,
                  fmt::format("unknown key 'tracer.{}', the nearest is 'tracer.{}'", name, nearest_name(name, known)));
    }
    try {
      TracerSettings scratch;
      set_option(scratch, name, text.value);
    } catch (const Error& error) {
      const std::string flag = flag_of(name) + ": ";
      const std::string& rule = error.rule();
      throw Error(text.place.file, line,
                  fmt::format("tracer.{}: {}", name, rule.starts_with(flag) ? rule.substr(flag.size()) : rule));
    }
    options[name] = text.value;
  }
  return options;
}

}  // namespace

ChosenMachine choose_machine(const MachineChoice& choice, bool check) {
  sim::ConfigSource source{.machine = choice.machine, .file = choice.config, .settings = choice.settings};
  if (!choice.design.empty()) {
    const explore::Design& design = explore::design_of(choice.design);
    source.design = design.name;
    source.design_keys = explore::keys_for(design, choice.k != 0 ? choice.k : explore::k_of(design));
  }
  sim::LoadedConfig loaded = sim::load_machine(source, check);
  const bool own = choice.machine.empty() || loaded.machine_hash == loaded.undesigned_hash;
  ChosenMachine chosen{machine_name(choice.machine) + (own ? "" : ", changed"),
                       std::move(loaded.config),
                       checked(loaded.tracer),
                       std::move(loaded.places),
                       loaded.rivals,
                       std::move(loaded.files),
                       std::move(loaded.machine_hash)};
  return chosen;
}

sim::GpuConfig load_machine_config(const std::string& machine, const std::string& config,
                                   const std::vector<std::string>& settings) {
  return choose_machine({.machine = machine, .config = config, .settings = settings}).config;
}

sim::KeyPlaces machine_places(const std::string& machine, const std::string& config) {
  return choose_machine({.machine = machine, .config = config}).places;
}

std::string describe_machine(const std::string& machine, const std::string& config,
                             const std::vector<std::string>& settings, sim::SimulationMode mode) {
  return fmt::format("machine: {}{}{}; mode {}, model version {}", machine, config.empty() ? "" : ", with " + config,
                     settings.empty() ? "" : fmt::format(", {}", fmt::join(settings, ", ")), name_of(mode),
                     sim::kModelVersion);
}

std::string machine_name(const std::string& machine) {
  return machine.ends_with(".toml") ? fs::path(machine).stem().string() : machine;
}

std::string machine_name(const std::string& machine, const sim::GpuConfig& config, const std::string& hash) {
  const bool own = machine.empty() || sim::config_hash(config) ==
                                          (hash.empty() ? choose_machine({.machine = machine}).machine_hash : hash);
  return machine_name(machine) + (own ? "" : ", changed");
}

std::map<std::string, std::string> machine_tracer(const std::string& machine) {
  return choose_machine({.machine = machine}).tracer;
}

void apply_tracer(TracerSettings& settings, const std::map<std::string, std::string>& options,
                  const std::function<bool(const std::string&)>& named) {
  for (const auto& [key, value] : options) {
    if (!named || !named(key)) set_option(settings, key, value);
  }
}

void apply_machine_tracer(TracerSettings& settings, const std::string& machine,
                          const std::function<bool(const std::string&)>& named) {
  apply_tracer(settings, machine_tracer(machine), named);
}

}  // namespace grtx::experiment
