// SPDX-License-Identifier: Apache-2.0
// A machine: a name for a hardware configuration and the tracer options that go with it. A file in configs/machines
// holds both: configuration keys, and tracer options in [tracer], written with _ for -. A file lists only differences
// from the machine that it includes, or from `paper` if it includes none.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "grtx/rtl_tlm/config/config_file.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"
#include "grtx/study/machines_folder.h"
#include "grtx/study/tracer_settings.h"

namespace grtx::study {

/// Sets the folder with the project's machines. It is used only if no machines are installed beside the program.
void set_machines_folder(const std::string& folder);

/// Machine used when a command names none.
inline constexpr const char* kDefaultMachine = "paper";

/// Names of all machines of the project, sorted.
std::vector<std::string> machine_names();

/// machine: a name, the path of a file, or "" for no machine: all keys at their defaults, which are those of `paper`,
/// and no tracer options. Then applies the file `config` unless it is "", then the settings, each "key=value". Throws
/// Error for unknown names, keys and values.
sim::GpuConfig load_machine_config(const std::string& machine, const std::string& config,
                                   const std::vector<std::string>& settings);

/// Where files set each key, and each tracer option as "tracer.NAME"; keys of defaults are missing.
sim::KeyPlaces machine_places(const std::string& machine, const std::string& config);

/// Line printed before results: "machine: NAME", the changes made on the command line, mode and model version.
std::string describe_machine(const std::string& machine, const std::string& config,
                             const std::vector<std::string>& settings, sim::SimulationMode mode);

/// Name of a machine in statistics. For a file: its name without folder and extension, so that statistics do not depend
/// on its location.
std::string machine_name(const std::string& machine);

/// The name of `machine`, followed by ", changed" if `config` differs from its configuration; "" if `machine` is "".
std::string machine_name(const std::string& machine, const sim::GpuConfig& config);

/// Applies the machine's tracer options, except keys for which `named` returns true (set by the user). Throws
/// Error{file, key, rule}.
void apply_machine_tracer(TracerSettings& settings, const std::string& machine,
                          const std::function<bool(const std::string&)>& named = nullptr);

/// The tracer options of a machine, by name with _ for -; empty for "". Throws Error as load_machine_config() does.
std::map<std::string, std::string> machine_tracer(const std::string& machine);

}  // namespace grtx::study
