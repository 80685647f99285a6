// SPDX-License-Identifier: Apache-2.0
#include "grtx/study/machine.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"
#include "grtx/rtl_tlm/config/config_file.h"
#include "grtx/rtl_tlm/run/model_version.h"

namespace grtx::study {
namespace {

namespace fs = std::filesystem;

std::string& folder_of_program() {
  static std::string folder;
  return folder;
}

/// Candidate folders: the installed one relative to the program, then the one given to set_machines_folder().
std::vector<fs::path> machines_folders() {
  std::error_code failed;
  const fs::path program = fs::read_symlink("/proc/self/exe", failed);
  const fs::path installed = program.parent_path() / ".." / GRTX_MACHINES_INSTALLED;
  return {installed.lexically_normal(), folder_of_program()};
}

fs::path machines_folder() {
  std::error_code failed;
  const std::vector<fs::path> folders = machines_folders();
  return fs::is_directory(folders.front(), failed) ? folders.front() : folders.back();
}

std::string path_of(const std::string& machine) {
  if (machine.ends_with(".toml")) return machine;
  const std::vector<std::string> names = machine_names();
  if (names.empty()) {
    throw Error("--machine", machine,
                fmt::format("no machines are in {} or {}; a file of your own ends in .toml",
                            machines_folders().front().string(), machines_folders().back().string()));
  }
  if (std::find(names.begin(), names.end(), machine) == names.end()) {
    throw Error("--machine", machine,
                fmt::format("is none of {}; the nearest is {}; a file of your own ends in .toml",
                            fmt::join(names, ", "), nearest_name(machine, names)));
  }
  return (machines_folder() / (machine + ".toml")).string();
}

/// Declares the tracer's options as keys tracer.NAME; their values are stored in `values`.
void add_tracer_keys(modules::ParameterList& list, std::map<std::string, std::string>& values) {
  list.under("tracer", [&](modules::ParameterList& tracer) {
    for (const TracerOptionName& option : tracer_option_names()) {
      tracer.add(option.key.c_str(), values[option.key], {}, option.description, modules::kOurs);
    }
  });
}

/// Loads `paper`, then the file on top: hardware keys into `config`; returns the tracer options by name.
std::map<std::string, std::string> read_machine(const std::string& path, sim::GpuConfig& config) {
  std::map<std::string, std::string> tracer;
  modules::ParameterList list;
  config.parameters(list);
  add_tracer_keys(list, tracer);
  sim::load_config_file(path_of(kDefaultMachine), list.items());
  sim::load_config_file(path, list.items());
  std::erase_if(tracer, [](const auto& entry) { return entry.second.empty(); });
  return tracer;
}

}  // namespace

std::vector<std::string> machine_names() {
  std::vector<std::string> names;
  std::error_code failed;
  for (const auto& file : fs::directory_iterator(machines_folder(), failed)) {
    if (file.path().extension() == ".toml") names.push_back(file.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

void set_machines_folder(const std::string& folder) { folder_of_program() = folder; }

sim::GpuConfig load_machine_config(const std::string& machine, const std::string& config,
                                   const std::vector<std::string>& settings) {
  sim::GpuConfig resolved;
  if (!machine.empty()) read_machine(path_of(machine), resolved);
  return sim::load_config(std::move(resolved), machine, config, settings);
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

std::string machine_name(const std::string& machine, const sim::GpuConfig& config) {
  const bool own =
      machine.empty() || sim::config_hash(load_machine_config(machine, "", {})) == sim::config_hash(config);
  return machine_name(machine) + (own ? "" : ", changed");
}

std::map<std::string, std::string> machine_tracer(const std::string& machine) {
  sim::GpuConfig unused;
  return machine.empty() ? std::map<std::string, std::string>() : read_machine(path_of(machine), unused);
}

void apply_machine_tracer(TracerSettings& settings, const std::string& machine,
                          const std::function<bool(const std::string&)>& named) {
  const std::map<std::string, std::string> chosen = machine_tracer(machine);
  for (const auto& [key, value] : chosen) {
    if (named && named(key)) continue;
    try {
      set_option(settings, key, value);
    } catch (const Error& error) {
      throw Error(path_of(machine), "tracer." + key, error.rule());
    }
  }
}

}  // namespace grtx::study
