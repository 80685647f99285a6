// SPDX-License-Identifier: Apache-2.0
// `grtx run` as a function: traces one view with each design, simulates them on one machine or several, compares them,
// and writes results.json, report.html, pictures and traces into a folder.
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "grtx/experiment/design_comparison.h"
#include "grtx/experiment/machine.h"
#include "grtx/experiment/tracer_settings.h"
#include "grtx/experiment/view_choice.h"
#include "grtx/frontend/tracer/tracer_counters.h"
#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"
#include "grtx/rtl_tlm/run/result_notes.h"

namespace grtx {
class FilesRead;
}

namespace grtx::experiment {

/// A machine of a run, and how the tracer works for it.
struct MachinePlan {
  std::string machine = kDefaultMachine;  ///< a name, or a file
  TracerSettings tracer;
  sim::GpuConfig config;  ///< the hardware of all designs, but for a design's own keys
  /// Tracer options of the machine and its file, which designs override; none: those of the machine.
  std::optional<std::map<std::string, std::string>> chosen_tracer;
  std::string machine_hash;  ///< ChosenMachine::machine_hash; "": the machine is read
};

struct RunPlan : MachinePlan {
  std::string scene;  ///< file, or list of objects
  ViewOptions view;
  std::vector<MachinePlan> further;         ///< more machines, on which the same designs run
  std::vector<std::string> designs;         ///< names; empty: all (explore/sweep/designs.h)
  std::set<std::string> named;              ///< tracer options and configuration keys that a design leaves as they are
  std::string output;                       ///< folder
  bool flatten = false;                     ///< merge a list of objects into one scene
  std::optional<sim::SimulationMode> mode;  ///< none: chosen by unnamed_mode()
  sim::WindowOptions windows;
  bool latency = false;  ///< where reads spend their time; of mode cycle, which it chooses
  unsigned jobs = 0;     ///< parallel simulations, each a process; 0: one per core, limited by free memory
  bool quiet = false;    ///< no progress on stderr
  std::function<void(const FilesRead&)> opened;  ///< called with all files read, before any is written
};
/// Configuration of a design on a machine of the plan: the machine's, with the design's own keys.
sim::GpuConfig design_config(const RunPlan& plan, const MachinePlan& machine, const explore::Design& design);
/// The machines of a plan, the first first.
std::vector<MachinePlan> machines_of(const RunPlan& plan);
/// Returns a plan for a machine, with its tracer options. machine: a name (set_machines_folder()) or a file. settings:
/// "key=value". Throws Error for unknown names, keys or values.
RunPlan plan_on(const std::string& machine, const std::vector<std::string>& settings = {});

struct DesignResults {
  explicit DesignResults(const DesignComparison& of) : comparison(of) {}
  DesignComparison comparison;
  nlohmann::ordered_json json;  ///< results.json, grtx.run/2
  sim::SimulationMode mode = sim::SimulationMode::cycle;
  frontend::TracerCounters counters;              ///< of the design that speed-ups are over
  std::map<std::string, sim::ResultNotes> notes;  ///< limitations of each design's figures; "DESIGN on MACHINE"
  std::vector<std::string> violations;            ///< violated conservation laws, "DESIGN: ..."
  bool images_identical = true;
  /// Whether all designs gave the same image and no conservation law was violated.
  bool sound() const { return images_identical && violations.empty(); }
};

/// Forks, so no other thread may hold a lock. Throws Error before writing anything if the plan cannot be run, and if
/// another process is writing to the folder.
DesignResults run_designs(RunPlan plan);

/// Paths of all files that run_designs() may write into `folder`. views: as ViewOptions::views. machines: as
/// MachinePlan::machine.
std::vector<std::string> run_files(const std::string& folder, const std::string& views,
                                   const std::vector<std::string>& machines = {});

}  // namespace grtx::experiment
