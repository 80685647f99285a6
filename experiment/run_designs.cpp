// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/run_designs.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <system_error>
#include <utility>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/file_lock.h"
#include "grtx/base/hash.h"
#include "grtx/base/json.h"
#include "grtx/experiment/design_results.h"
#include "grtx/experiment/option_text.h"
#include "grtx/experiment/simulate_designs.h"
#include "grtx/experiment/trace_designs.h"
#include "grtx/explore/cost/energy_statistics.h"
#include "grtx/frontend/accel/object_list.h"
#include "grtx/frontend/image/image.h"
#include "grtx/report/page/report.h"
#include "grtx/rtl_tlm/estimate/windows/window_refusal.h"
#include "grtx/rtl_tlm/gpu/idle_keys.h"
#include "grtx/traces/reader.h"

namespace grtx::experiment {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr const char* kLock = "run.lock";

/// With ErtCheck::round an image depends on k: designs that blend in one order must have one k. Throws Error.
void check_one_k(const RunPlan& plan, const DesignComparison& comparison) {
  std::map<std::string, unsigned> k_of;
  for (const MachinePlan& machine : machines_of(plan)) {
    for (const ComparedDesign& design : comparison.designs()) {
      const TracerSettings settings = design_settings(machine.tracer, design, plan.named);
      const frontend::TracerOptions options = tracer_options(settings, design.checkpoint, design.kind);
      const unsigned k = k_of.try_emplace(order_of(settings, design.kind), options.k).first->second;
      if (options.ert_check == frontend::ErtCheck::round && k != options.k) {
        throw Error("--ert-check", "round",
                    "gives images that differ with k; run compares identical ones: it needs --k");
      }
    }
  }
}

/// Machines are told apart by name, and draw one picture: an option that a picture depends on is the same for all.
/// Throws Error.
void check_machines(const RunPlan& plan) {
  std::set<std::string> names;
  for (const MachinePlan& machine : machines_of(plan)) {
    const std::string name = machine_name(machine.machine);
    if (!names.insert(name).second) throw Error("--machine", name, "is there twice");
    const std::map<std::string, std::string> own = option_texts(machine.tracer), first = option_texts(plan.tracer);
    for (const char* option : {"ert", "ert_check", "sort_key", "resume", "kernel_radius", "kernel_degree", "inside",
                               "sh_dir", "colour", "triangle_test", "response_precision", "layout"}) {
      if (own.at(option) == first.at(option)) continue;
      throw Error("--machine", name,
                  fmt::format("has {} = {}, {} has {}: machines of a run draw one picture; {} sets it for all", option,
                              own.at(option), machine_name(plan.machine), first.at(option), flag_of(option)));
    }
  }
}

/// Throws Error for what a design refuses of the options and keys on any machine.
void check_design_of(const RunPlan& plan, const ComparedDesign& design) {
  for (const MachinePlan& machine : machines_of(plan)) {
    const TracerSettings settings = design_settings(machine.tracer, design, plan.named);
    tracer_options(settings, design.checkpoint, design.kind);
    accel_options(settings, design.kind);
    const sim::GpuConfig config = design_config(plan, machine, design);
    if (config.rt.any_hit_unit.enabled && settings.tracing != name_of(traces::Tracing::multi)) {
      throw Error("--tracing", settings.tracing, "has no rounds of k hits, which are what the design's heaps hold");
    }
    sim::check_config(
        config, "design " + design.name + (plan.further.empty() ? "" : " on machine " + machine_name(machine.machine)));
    sim::check_mode(config, plan.mode.value_or(sim::SimulationMode::cycle));
  }
}

/// Throws Error for options with which designs cannot be compared.
void check_plan(const RunPlan& plan, const DesignComparison& comparison) {
  check_machines(plan);
  for (const MachinePlan& machine : machines_of(plan)) {
    if (machine.tracer.options.triangle_test == frontend::TriangleTest::world) {
      throw Error("--triangle-test", "world",
                  "gives images that differ with the structure; run compares identical ones");
    }
  }
  for (const ComparedDesign& design : comparison.designs()) check_design_of(plan, design);
  check_secondary(plan.tracer.secondary);
  check_one_k(plan, comparison);
  if (plan.latency && plan.mode == sim::SimulationMode::windows) sim::refuse_latency("run");
  if (!plan.view.views.empty()) sim::check_mode_of_frames(plan.mode.value_or(sim::SimulationMode::cycle));
}

/// Keys that are set and have no effect in any of the designs on any machine.
std::vector<sim::IdleKey> idle_in_all(const RunPlan& plan, const DesignComparison& comparison) {
  std::vector<sim::IdleKey> idle = sim::idle_keys(plan.config);
  for (const MachinePlan& machine : machines_of(plan)) {
    for (const ComparedDesign& design : comparison.designs()) {
      const std::vector<sim::IdleKey> own = sim::idle_keys(design_config(plan, machine, design));
      std::erase_if(idle, [&](const sim::IdleKey& key) {
        return std::none_of(own.begin(), own.end(), [&](const sim::IdleKey& other) { return other.key == key.key; });
      });
    }
  }
  return idle;
}

/// Makes a folder and those above it; removes what it made when nothing was written there: a refused run leaves none.
class MadeFolder {
 public:
  explicit MadeFolder(const std::string& path) {
    std::error_code failed;
    for (fs::path at = fs::absolute(path).lexically_normal(); !fs::exists(at, failed); at = at.parent_path()) {
      if (at.has_filename()) made_.push_back(at);
    }
    fs::create_directories(path, failed);
    if (failed) throw Error(path, "", "cannot be made a folder: " + failed.message());
  }
  ~MadeFolder() {
    std::error_code not_empty;
    for (const fs::path& folder : made_) fs::remove(folder, not_empty);
  }
  MadeFolder(const MadeFolder&) = delete;
  MadeFolder& operator=(const MadeFolder&) = delete;

 private:
  std::vector<fs::path> made_;  ///< the innermost first
};

bool is_plain_file(const std::string& path) { return fs::is_regular_file(fs::symlink_status(path)); }

/// Whether the file is the trace with this hash.
bool is_trace(const std::string& path, const std::string& hash) {
  try {
    return is_plain_file(path) && traces::Reader(path).content_hash() == hash;
  } catch (const Error&) {
    return false;
  }
}

/// Traces in a folder that its results name and that are unchanged since.
std::vector<std::string> traces_of(const ordered_json& results, const std::string& folder) {
  std::vector<std::string> files;
  for (const ordered_json& machine : results.value("machines", ordered_json::array({results}))) {
    const ordered_json inputs = machine.value("inputs", ordered_json::object());
    for (const std::string& design : explore::design_names()) {
      if (!inputs.contains(design)) continue;
      const std::string name = machine.value("machine", "");
      for (const std::string& of : {std::string(), name.substr(0, name.find(','))}) {
        const std::string file = trace_path(folder, design, of);
        if (is_trace(file, inputs.at(design).value("trace_hash", ""))) files.push_back(file);
      }
    }
  }
  return files;
}

/// Removes results.json, report.html, the pictures of an earlier run, and its traces but those in `written`. Pictures
/// and traces go only if its results name them and they are unchanged since.
void remove_earlier_run(const std::string& folder, const std::set<std::string>& written) {
  const std::string path = folder + "/results.json";
  if (!fs::exists(path)) return;
  std::vector<std::string> files = {path, folder + "/report.html"};
  try {
    const ordered_json earlier = read_json(path);
    for (const ordered_json& image : earlier.value("images", ordered_json::array())) {
      const std::string file = folder + "/" + image.value("file", "");
      const bool beside = fs::path(file).parent_path() == folder && is_plain_file(file);
      if (beside && hex(xxh3(read_file(file))) == image.value("hash", "")) files.push_back(file);
    }
    for (const std::string& file : traces_of(earlier, folder)) {
      if (!written.contains(file)) files.push_back(file);
    }
  } catch (const Error&) {  // not results of a run: removed as well
  } catch (const ordered_json::exception&) {
  }
  for (const std::string& file : files) fs::remove(file);
}

/// Writes one picture per frame. Returns [{"file", "hash"}] for results.json; by the hash a report checks that a
/// picture is of this run.
ordered_json write_run_images(const std::string& folder, const std::vector<frontend::Image>& images) {
  ordered_json list = ordered_json::array();
  for (std::size_t i = 0; i < images.size(); ++i) {
    const std::string path = images.size() == 1 ? folder + "/image.png" : frame_path(folder + "/image.png", i);
    frontend::write_image(path, images[i]);
    list.push_back({{"file", std::filesystem::path(path).filename().string()}, {"hash", hex(xxh3(read_file(path)))}});
  }
  return list;
}

}  // namespace

sim::GpuConfig design_config(const RunPlan& plan, const MachinePlan& machine, const explore::Design& design) {
  return explore::with_keys_of(design, design_settings(machine.tracer, design, plan.named).options.k, machine.config,
                               plan.named);
}

std::vector<MachinePlan> machines_of(const RunPlan& plan) {
  std::vector<MachinePlan> machines = {plan};  // what it has of a machine
  machines.insert(machines.end(), plan.further.begin(), plan.further.end());
  return machines;
}

RunPlan plan_on(const std::string& machine, const std::vector<std::string>& settings) {
  RunPlan plan;
  plan.machine = machine;
  ChosenMachine chosen = choose_machine({.machine = machine, .settings = settings}, false);  // checked for each design
  plan.config = std::move(chosen.config);
  plan.named = explore::keys_of(settings);
  apply_tracer(plan.tracer, chosen.tracer);
  plan.chosen_tracer = std::move(chosen.tracer);
  plan.machine_hash = std::move(chosen.machine_hash);
  return plan;
}

DesignResults run_designs(RunPlan plan) {
  const bool objects = frontend::is_object_list(plan.scene) && !plan.flatten;
  const DesignComparison comparison(plan.designs, objects,
                                    [&](const ComparedDesign& design) { check_design_of(plan, design); });
  check_plan(plan, comparison);
  for (const auto& [name, why] : comparison.left_out()) {
    fmt::print(stderr, "grtx: run: {} is left out: {}\n", name, why);
  }
  sim::warn_of(idle_in_all(plan, comparison));
  const MadeFolder folder(plan.output);
  const FileLock lock(plan.output + "/" + kLock, plan.output, "another grtx run is filling it");

  const std::vector<MachinePlan> machines = machines_of(plan);
  DesignTracing tracing{.scene = plan.scene,
                        .view = plan.view,
                        .machines = {},
                        .several_objects = objects,
                        .folder = plan.output,
                        .named = plan.named,
                        .quiet = plan.quiet,
                        .opened = plan.opened};
  for (const MachinePlan& machine : machines) {
    tracing.machines.push_back({machine_name(machine.machine), machine.tracer});
  }
  const std::vector<TracedDesigns> traced = trace_designs(tracing, comparison);
  std::set<std::string> written;
  for (const TracedDesigns& on : traced) {
    for (const auto& [name, design] : on.designs) written.insert(design.path);
  }
  remove_earlier_run(plan.output, written);
  const ordered_json images = write_run_images(plan.output, traced.front().images);
  plan.windows.price = explore::describe_energy;
  std::vector<MachineSimulation> simulations;
  for (std::size_t m = 0; m < machines.size(); ++m) {
    MachineSimulation& on = simulations.emplace_back();
    if (machines.size() > 1) on.name = machine_name(machines[m].machine);
    on.traced = &traced[m];
    on.machine = machines[m].config;
    for (const ComparedDesign& design : comparison.designs()) {
      on.configs[design.name] = design_config(plan, machines[m], design);
    }
  }
  if (!plan.mode && plan.latency) plan.mode = sim::SimulationMode::cycle;
  if (!plan.mode) plan.mode = unnamed_mode(simulations, comparison, plan.windows);
  DesignResults results = design_results(
      plan, comparison, traced,
      simulate_designs(simulations, comparison, {*plan.mode, plan.windows, plan.jobs, plan.quiet, plan.latency}),
      images);

  const std::string path = plan.output + "/results.json";
  write_file(path, json_text(results.json, 1) + "\n");
  report::ReportOptions report;
  report.inputs = {path};
  write_file(plan.output + "/report.html", report::report_page(report));
  return results;
}

std::vector<std::string> run_files(const std::string& folder, const std::string& views,
                                   const std::vector<std::string>& machines) {
  std::vector<std::string> files = frame_paths(folder + "/image.png", views);
  std::set<std::string> names = {""};  // one that is there twice is refused later
  for (const std::string& machine : machines) names.insert(machine_name(machine));
  for (const std::string& design : explore::design_names()) {
    for (const std::string& name : names) files.push_back(trace_path(folder, design, name));
  }
  for (const char* name : {"results.json", "report.html", kLock}) files.push_back(folder + "/" + name);
  return files;
}

}  // namespace grtx::experiment
