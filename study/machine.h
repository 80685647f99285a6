// A machine: one word for a hardware configuration and the tracer options that go with it. A file in configs/machines
// holds both: keys of the configuration, and in [tracer] options of the tracer, with _ for -. A file says what differs
// from the machine that it includes, and where it includes none, from `paper`.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"
#include "grtx/study/machines_folder.h"
#include "grtx/study/tracer_settings.h"

namespace grtx::sim {

/// Where machines of the project are, unless they are installed beside the program.
void set_machines_folder(const std::string& folder);

/// What every command takes that names none.
inline constexpr const char* kDefaultMachine = "paper";

/// Those of the project.
std::vector<std::string> machine_names();

/// machine: a name, the path of a file, or "" for no machine: all keys at their defaults, which are those of `paper`,
/// and no tracer options. Then the file `config`, if not "", and the settings key=value. Throws Error for unknown
/// names, keys and values.
GpuConfig load_machine_config(const std::string& machine, const std::string& config,
                              const std::vector<std::string>& settings);

/// What the figures behind it are of: "machine: NAME", with what the command line changes about it, mode and version of
/// the model.
std::string describe_machine(const std::string& machine, const std::string& config,
                             const std::vector<std::string>& settings, SimulationMode mode);

/// A machine's name in statistics: of a file the name without folder and ending, so that they do not depend on where it
/// lies.
std::string machine_name(const std::string& machine);

/// That of the machine whose keys these are: `machine`, another of the project, or "`machine`, changed"; "" for
/// neither.
std::string machine_name(const std::string& machine, const GpuConfig& config);

/// Gives the tracer the options of the machine, but for those that somebody named: keys, for which `named` is true.
/// Throws Error{file, key, rule}.
void apply_machine_tracer(TracerSettings& settings, const std::string& machine,
                          const std::function<bool(const std::string&)>& named = nullptr);

/// The tracer options of a machine, by name with _ for -; none for "". Throws as above.
std::map<std::string, std::string> machine_tracer(const std::string& machine);

}  // namespace grtx::sim
