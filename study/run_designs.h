// All of `grtx run`, as a function: traces one view with each design, simulates each, compares, and writes
// results.json, report.html, pictures and traces into a folder.
#pragma once

#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "grtx/base/files_read.h"
#include "grtx/frontend/tracer/tracer.h"
#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"
#include "grtx/rtl_tlm/run/result_notes.h"
#include "grtx/study/design_comparison.h"
#include "grtx/study/machine.h"
#include "grtx/study/tracer_settings.h"
#include "grtx/study/view_choice.h"

namespace grtx::sim {

struct RunPlan {
  std::string scene;  ///< file, or list of objects
  ViewOptions view;
  TracerSettings tracer;
  std::string machine = kDefaultMachine;  ///< its name in results
  GpuConfig config;                       ///< the hardware of all designs
  std::string output;                     ///< folder
  bool flatten = false;                   ///< of a list of objects: all Gaussians in one scene
  std::optional<SimulationMode> mode;     ///< none: windows of full frames, which a line on stderr says, else cycle
  WindowOptions windows;
  unsigned jobs = 0;   ///< simulations at a time, each a process of its own; 0: one a core, while there is memory
  bool quiet = false;  ///< without progress on stderr
  std::function<void(const FilesRead&)> opened;  ///< called with all files that were read, before any is written
};
/// A plan on a machine: a name (set_machines_folder()) or a file, with the tracer options that go with it. settings:
/// key=value. Throws Error.
RunPlan plan_on(const std::string& machine, const std::vector<std::string>& settings = {});

struct DesignResults {
  explicit DesignResults(const DesignComparison& of) : comparison(of) {}
  DesignComparison comparison;
  nlohmann::ordered_json json;  ///< results.json, grtx.run/1
  SimulationMode mode = SimulationMode::cycle;
  frontend::TracerCounters counters;         ///< of a design; rays end alike in each
  std::map<std::string, ResultNotes> notes;  ///< what limits each design's figures
  std::vector<std::string> violations;       ///< of conservation laws, "DESIGN: ..."
  bool images_identical = true;
  /// Whether all designs saw one picture and lost nothing.
  bool sound() const { return images_identical && violations.empty(); }
};

/// Forks: no thread of the process may hold a lock. Throws Error for a plan that cannot be run, before anything is
/// written, and when another process is filling the folder.
DesignResults run_designs(RunPlan plan);

/// Everything that it may write into its folder. views: as ViewOptions::views.
std::vector<std::string> run_files(const std::string& folder, const std::string& views);

}  // namespace grtx::sim
