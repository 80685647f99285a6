// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/run_designs.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <system_error>
#include <utility>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/file_lock.h"
#include "grtx/base/hash.h"
#include "grtx/base/json.h"
#include "grtx/experiment/design_results.h"
#include "grtx/experiment/simulate_designs.h"
#include "grtx/experiment/trace_designs.h"
#include "grtx/explore/cost/energy_statistics.h"
#include "grtx/frontend/accel/object_list.h"
#include "grtx/frontend/image/image.h"
#include "grtx/report/page/report.h"
#include "grtx/rtl_tlm/gpu/idle_keys.h"
#include "grtx/traces/reader.h"

namespace grtx::experiment {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr const char* kLock = "run.lock";

/// With ErtCheck::round an image depends on k: designs that blend in one order must have one k. Throws Error.
void check_one_k(const RunPlan& plan, const DesignComparison& comparison) {
  std::map<frontend::SortKey, unsigned> k_of;
  for (const ComparedDesign& design : comparison.designs()) {
    const frontend::TracerOptions options =
        tracer_options(design_settings(plan.tracer, design, plan.named), design.checkpoint, design.kind);
    const unsigned k = k_of.try_emplace(options.sort_key, options.k).first->second;
    if (options.ert_check == frontend::ErtCheck::round && k != options.k) {
      throw Error("--ert-check", "round", "gives images that differ with k; run compares identical ones: it needs --k");
    }
  }
}

/// Throws Error for options with which designs cannot be compared.
void check_plan(const RunPlan& plan, const DesignComparison& comparison) {
  if (plan.tracer.options.triangle_test == frontend::TriangleTest::world) {
    throw Error("--triangle-test", "world", "gives images that differ with the structure; run compares identical ones");
  }
  for (const ComparedDesign& design : comparison.designs()) {
    tracer_options(design_settings(plan.tracer, design, plan.named), design.checkpoint, design.kind);
    sim::check_config(design_config(plan, design), "design " + design.name);
    sim::check_mode(design_config(plan, design), plan.mode.value_or(sim::SimulationMode::cycle));
  }
  check_secondary(plan.tracer.secondary);
  check_one_k(plan, comparison);
  if (!plan.view.views.empty() && plan.mode == sim::SimulationMode::windows) {
    throw Error("--mode", "windows", "has no caches to keep warm from frame to frame: --views needs cycle");
  }
}

/// Keys that are set and have no effect in any of the designs.
std::vector<sim::IdleKey> idle_in_all(const RunPlan& plan, const DesignComparison& comparison) {
  std::vector<sim::IdleKey> idle = sim::idle_keys(plan.config);
  for (const ComparedDesign& design : comparison.designs()) {
    const std::vector<sim::IdleKey> own = sim::idle_keys(design_config(plan, design));
    std::erase_if(idle, [&](const sim::IdleKey& key) {
      return std::none_of(own.begin(), own.end(), [&](const sim::IdleKey& other) { return other.key == key.key; });
    });
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

/// Removes results.json, report.html, the pictures of an earlier run, and its traces of designs that are not compared
/// now. Pictures and traces go only if its results name them and they are unchanged since.
void remove_earlier_run(const std::string& folder, const DesignComparison& comparison) {
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
    const ordered_json inputs = earlier.value("inputs", ordered_json::object());
    for (const std::string& design : explore::design_names()) {
      if (!inputs.contains(design)) continue;
      const bool compared = std::ranges::any_of(comparison.designs(), [&](const auto& d) { return d.name == design; });
      const std::string file = fmt::format("{}/{}.grtx", folder, design);
      if (!compared && is_trace(file, inputs.at(design).value("trace_hash", ""))) files.push_back(file);
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

sim::GpuConfig design_config(const RunPlan& plan, const explore::Design& design) {
  return explore::with_keys_of(design, design_settings(plan.tracer, design, plan.named).options.k, plan.config,
                               plan.named);
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
  const DesignComparison comparison(plan.designs, objects);
  check_plan(plan, comparison);
  sim::warn_of(idle_in_all(plan, comparison));
  const MadeFolder folder(plan.output);
  const FileLock lock(plan.output + "/" + kLock, plan.output, "another grtx run is filling it");

  const TracedDesigns traced = trace_designs(
      {plan.scene, plan.view, plan.tracer, objects, plan.output, plan.named, plan.quiet, plan.opened}, comparison);
  remove_earlier_run(plan.output, comparison);
  const ordered_json images = write_run_images(plan.output, traced.images);
  plan.windows.price = explore::describe_energy;
  if (!plan.mode) plan.mode = unnamed_mode(traced, comparison, plan.config, plan.windows);
  std::map<std::string, sim::GpuConfig> configs;
  for (const ComparedDesign& design : comparison.designs()) configs[design.name] = design_config(plan, design);
  const DesignSimulation simulation{std::move(configs), *plan.mode, plan.windows, plan.jobs, plan.quiet};
  DesignResults results =
      design_results(plan, comparison, traced, simulate_designs(traced, comparison, simulation), images);

  const std::string path = plan.output + "/results.json";
  write_file(path, json_text(results.json, 1) + "\n");
  report::ReportOptions report;
  report.inputs = {path};
  write_file(plan.output + "/report.html", report::report_page(report));
  return results;
}

std::vector<std::string> run_files(const std::string& folder, const std::string& views) {
  std::vector<std::string> files = frame_paths(folder + "/image.png", views);
  for (const std::string& design : explore::design_names()) files.push_back(fmt::format("{}/{}.grtx", folder, design));
  for (const char* name : {"results.json", "report.html", kLock}) files.push_back(folder + "/" + name);
  return files;
}

}  // namespace grtx::experiment
