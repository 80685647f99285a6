// SPDX-License-Identifier: Apache-2.0
// A machine: a name for a hardware configuration and the tracer options that go with it. A file in configs/machines
// holds both: configuration keys, and tracer options in [tracer], written with _ for -. A file lists only differences
// from the machine that it includes, or from `paper` if it includes none.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "grtx/experiment/machines_folder.h"
#include "grtx/experiment/tracer_settings.h"
#include "grtx/rtl_tlm/config/config_file.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"

namespace grtx::experiment {

using sim::kDefaultMachine;
using sim::machine_names;
using sim::set_machines_folder;

/// A command's settings of the machine, from the bottom up: each overrides those before it.
struct MachineChoice {
  std::string machine = kDefaultMachine;   ///< a name, a file, or "": all keys at their defaults, no tracer options
  std::string config = {};                 ///< a file of what differs, its tracer options included; "" for none
  std::string design = {};                 ///< a named design, whose own keys are set; "" for none
  unsigned k = 0;                          ///< of the trace, for a design's registers; 0: as the design has it
  std::vector<std::string> settings = {};  ///< each "key=value"
};
struct ChosenMachine {
  std::string name;  ///< in statistics: machine_name() of the machine without what the design brings
  sim::GpuConfig config;
  std::map<std::string, std::string> tracer;  ///< by name with _ for -; a design's own options are not among them
  sim::KeyPlaces places;                      ///< of keys, and of tracer options as "tracer.NAME"
  sim::RivalKeys rivals;
  std::vector<std::string> files;  ///< all that were read
  std::string machine_hash;        ///< config_hash() of the machine alone
};
/// The one place where machine, file, design and settings become a configuration. Throws Error for unknown names, keys
/// and values, tracer options included. check: as in sim::load_machine().
ChosenMachine choose_machine(const MachineChoice& choice, bool check = true);

/// The configuration of choose_machine().
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
/// hash: ChosenMachine::machine_hash; "": the machine is read.
std::string machine_name(const std::string& machine, const sim::GpuConfig& config, const std::string& hash);

/// Sets tracer options, except keys for which `named` returns true (set by the user).
void apply_tracer(TracerSettings& settings, const std::map<std::string, std::string>& options,
                  const std::function<bool(const std::string&)>& named = nullptr);
/// The same for the machine's. Throws Error{file, "line N", rule}.
void apply_machine_tracer(TracerSettings& settings, const std::string& machine,
                          const std::function<bool(const std::string&)>& named = nullptr);

/// The tracer options of a machine, by name with _ for -; empty for "". Throws Error as load_machine_config() does.
std::map<std::string, std::string> machine_tracer(const std::string& machine);

}  // namespace grtx::experiment
