// grtx run: the main job. Traces one view with the four designs, simulates each, and compares.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <thread>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/design_progress.h"
#include "grtx/apps/grtx/estimate_cli.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/machine.h"
#include "grtx/apps/grtx/machine_notes.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/apps/grtx/scene_cli.h"
#include "grtx/apps/grtx/tracer_cli.h"
#include "grtx/apps/grtx/tracer_statistics.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "grtx/base/file_lock.h"
#include "grtx/base/free_memory.h"
#include "grtx/base/hash.h"
#include "grtx/base/json.h"
#include "grtx/frontend/accel/object_list.h"
#include "grtx/frontend/image/image.h"
#include "grtx/lab/cost/energy_statistics.h"
#include "grtx/rtl_tlm/estimate/sampled_simulation.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/idle_keys.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"
#include "grtx/rtl_tlm/run/model_version.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "grtx/rtl_tlm/run/statistics_json.h"
#include "grtx/rtl_tlm/run/trace_source.h"
#include "grtx/traces/reader.h"
#include "grtx/view/report/report.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

struct Design {
  const char* name;
  frontend::AccelKind accel;
  bool checkpoint;
};
// The named designs of the paper's comparison, ordered so that two share one acceleration structure.
constexpr std::array<Design, 4> kDesigns = {{{"baseline", frontend::AccelKind::tri20, false},
                                             {"hw", frontend::AccelKind::tri20, true},
                                             {"sw", frontend::AccelKind::tlas_tri20, false},
                                             {"grtx", frontend::AccelKind::tlas_tri20, true}}};
constexpr const char* kLock = "run.lock";
constexpr const char* kChargedMachine = "paper-charged";  ///< the default machine with every byte charged
constexpr std::array<const char*, 4> kTableOrder = {"baseline", "sw", "hw", "grtx"};

/// The designs that a scene has: several objects need a two-level structure, so theirs are sw and grtx.
class Comparison {
 public:
  explicit Comparison(bool several_objects) {
    for (const Design& design : kDesigns) {
      if (!several_objects || traces::is_two_level(design.accel)) designs_.push_back(design);
    }
    for (const char* name : kTableOrder) {
      const auto has_name = [&](const Design& design) { return name == std::string_view(design.name); };
      if (std::any_of(designs_.begin(), designs_.end(), has_name)) names_.emplace_back(name);
    }
  }
  const std::vector<Design>& designs() const { return designs_; }   ///< in the order of tracing
  const std::vector<std::string>& names() const { return names_; }  ///< in the order of the table
  /// Over which speed-ups are.
  const std::string& reference() const { return names_.front(); }
  std::span<const std::string> others() const { return std::span(names_).subspan(1); }

 private:
  std::vector<Design> designs_;
  std::vector<std::string> names_;
};

struct RunArguments {
  std::string scene;
  ViewOptions view;
  TracerCli tracer;
  CLI::App* command = nullptr;
  std::string machine = kDefaultMachine;
  std::string config;
  std::vector<std::string> settings;
  std::string output;
  unsigned jobs = 0;
  bool flatten = false;
  SimulationMode mode = SimulationMode::cycle;
  CLI::Option* mode_option = nullptr;  ///< that `mode` was named by
  EstimateCli estimate;
};

struct Traced {
  std::string path;
  frontend::TraceFile file;
  ordered_json statistics;  ///< tracer.*, accel.*, trace.*
};

/// What tracing all designs gave.
struct TracedDesigns {
  std::map<std::string, Traced> designs;
  std::vector<frontend::Image> images;  ///< of the first, by frame
  bool identical = true;                ///< all images, to the bit
  frontend::TracerCounters counters;    ///< of the last; rays end alike in each
  std::string files_hash;               ///< of what cameras and scene were read from
};

TracedDesigns trace_designs(const RunArguments& options, const Comparison& comparison, bool several_objects,
                            const CommonOptions& common) {
  FilesRead files;
  const std::vector<frontend::Camera> cameras = select_cameras(options.view, files);
  frontend::SceneTracer scene;
  // All designs of several objects share one structure, which is built with them.
  load_scene(scene, options.scene, several_objects, cameras, options.tracer, comparison.designs().front().accel, files,
             common.quiet);
  common.files.check(files);
  TracedDesigns all;
  all.files_hash = files.hash();
  for (const Design& design : comparison.designs()) {
    frontend::RenderOptions render = render_options(options.tracer, common.quiet);
    render.count_unique = true;
    render.count_hits = !all.counters.hits;  // the same rays meet the same proxies in each design
    Traced& result = all.designs[design.name];
    result.path = options.output + "/" + design.name + ".grtx";
    frontend::TracedView traced =
        trace_scene(scene, options.tracer, design.checkpoint, design.accel, render, result.path, files);
    result.file = traced.trace.value();
    frontend::RenderResult& rendered = traced.result;
    if (!rendered.counters.hits) rendered.counters.hits = all.counters.hits;
    all.counters = rendered.counters;
    result.statistics = statistics_object(tracer_statistics(scene, traced));
    result.statistics.update(statistics_object(tracer_host_statistics(scene, rendered)));
    std::vector<frontend::Image> images = std::move(traced.further);
    images.insert(images.begin(), std::move(rendered.image));
    if (all.images.empty()) {
      all.images = std::move(images);
    } else {
      for (std::size_t i = 0; i < images.size(); ++i) {
        all.identical = all.identical && frontend::compare(all.images[i], images[i]).identical();
      }
    }
  }
  return all;
}

/// Results that an earlier run left go before the pictures of this one come, and so do its pictures: those that its
/// results name and that are still as it wrote them.
void remove_earlier_run(const std::string& folder) {
  const std::string path = folder + "/results.json";
  if (!std::filesystem::exists(path)) return;
  std::vector<std::string> files = {path, folder + "/report.html"};
  try {
    for (const ordered_json& image : read_json(path).value("images", ordered_json::array())) {
      const std::string file = folder + "/" + image.value("file", "");
      const bool beside = std::filesystem::path(file).parent_path() == folder && std::filesystem::is_regular_file(file);
      if (beside && hex(xxh3(read_file(file))) == image.value("hash", "")) files.push_back(file);
    }
  } catch (const Error&) {  // no results of ours: it is written over, as ever
  } catch (const ordered_json::exception&) {
  }
  for (const std::string& file : files) std::filesystem::remove(file);
}

/// One a frame. Returns [{"file", "hash"}] for results.json: what shows a picture can tell whether it is this run's.
ordered_json write_images(const std::string& folder, const std::vector<frontend::Image>& images) {
  ordered_json list = ordered_json::array();
  for (std::size_t i = 0; i < images.size(); ++i) {
    const std::string path = images.size() == 1 ? folder + "/image.png" : frame_path(folder + "/image.png", i);
    frontend::write_image(path, images[i]);
    list.push_back({{"file", std::filesystem::path(path).filename().string()}, {"hash", hex(xxh3(read_file(path)))}});
  }
  return list;
}

constexpr std::chrono::milliseconds kLook{200};                    ///< how often the parent looks at its simulations
constexpr std::uint64_t kMachineBytes = std::uint64_t{512} << 20;  ///< a simulation's, without the groups it decodes

/// As many simulations at a time as there are cores, and as fit into the memory that is free now.
unsigned default_jobs(const std::map<std::string, Traced>& traced, const GpuConfig& config) {
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  const std::optional<std::uint64_t> free = free_memory();
  if (!free) return cores;
  std::uint64_t groups = 0;
  for (const auto& [name, design] : traced) {
    const std::uint64_t resident = std::uint64_t{config.sms} * config.resident() * design.file.largest_group;
    groups = std::max(groups, std::min(design.file.decoded_bytes, resident + kDecodeAheadBytes));
  }
  return static_cast<unsigned>(std::clamp<std::uint64_t>(*free / (kMachineBytes + groups), 1, cores));
}

/// A run that names no mode takes windows where they pay. All designs have the same rays.
SimulationMode unnamed_mode(const TracedDesigns& traced, const Comparison& comparison, const GpuConfig& config,
                            const WindowOptions& windows) {
  const traces::Reader reader(traced.designs.at(comparison.reference()).path);
  if (!windows_pay(reader, config, windows)) return SimulationMode::cycle;
  fmt::print(stderr,
             "grtx: run: {} warps with {:.0f} M node visits: estimated from windows, with intervals; --mode cycle "
             "simulates all of them\n",
             reader.group_count(), static_cast<double>(reader.totals().visits()) * 1e-6);
  return SimulationMode::windows;
}

SimulationResult simulate_as(SimulationMode mode, const std::string& trace, const GpuConfig& config,
                             const SimulationOptions& simulation, const WindowOptions& windows) {
  if (mode == SimulationMode::windows) return simulate_windows(trace, config, windows).result;
  if (mode == SimulationMode::sampled) {
    return simulate_sampled(trace, config, simulation, windows.target_error).result;
  }
  return simulate(trace, config, simulation);
}

/// Simulates the traces in child processes, at most options.jobs at a time. Returns each design's statistics document.
std::map<std::string, ordered_json> simulate_designs(const std::map<std::string, Traced>& traced,
                                                     const Comparison& comparison, const GpuConfig& config,
                                                     const RunArguments& options, const WindowOptions& windows,
                                                     bool quiet) {
  const unsigned jobs = options.jobs == 0 ? default_jobs(traced, config) : options.jobs;
  std::map<std::string, ordered_json> documents;
  std::vector<std::pair<std::string, std::unique_ptr<ChildProcess>>> running;
  std::vector<std::string> names;
  std::vector<std::uint64_t> warps;
  for (const Design& design : comparison.designs()) {
    names.emplace_back(design.name);
    warps.push_back(traces::Reader(traced.at(design.name).path).group_count());
  }
  DesignProgress progress(names, warps, quiet);
  const auto collect_first = [&] {
    while (!running.front().second->wait_for(kLook)) progress.look();
    progress.look();
    documents[running.front().first] = parse_json(running.front().second->result(), running.front().first);
    running.erase(running.begin());
  };
  for (const Design& design : comparison.designs()) {
    if (running.size() >= jobs) collect_first();
    const std::size_t index = static_cast<std::size_t>(&design - comparison.designs().data());
    running.emplace_back(design.name, std::make_unique<ChildProcess>(design.name, [&, index, name = design.name] {
                           const std::string& trace = traced.at(name).path;
                           SimulationOptions simulation;
                           simulation.observer = progress.observer(index);
                           simulation.price = describe_energy;
                           const SimulationResult result =
                               simulate_as(options.mode, trace, config, simulation, windows);
                           ordered_json document = result.document;
                           document["violations"] = result.violations;
                           document["binding_bound"] = result.binding_bound;
                           return json_text(document);
                         }));
  }
  while (!running.empty()) collect_first();
  return documents;
}

double value(const ordered_json& statistics, const std::string& name) {
  return statistics.at(name).at("value").get<double>();
}

void print_table(const ordered_json& designs, const Comparison& comparison) {
  // 80 columns; visits, fetches and L2 accesses in millions.
  fmt::print("{:<8} {:>11} {:>8} {:>8} {:>9} {:>7} {:>6} {:>8} {:>7}\n", "design", "cycles", "speed-up", "visits M",
             "fetches M", "latency", "L1 hit", "L2 M", "DRAM MB");
  const double reference = value(designs.at(comparison.reference()), "gpu.cycles");
  for (const std::string& name : comparison.names()) {
    const ordered_json& s = designs.at(name);
    fmt::print("{:<8} {:>11.0f} {:>8.2f} {:>8.3f} {:>9.3f} {:>7.1f} {:>5.1f}% {:>8.3f} {:>7.1f}\n", name,
               value(s, "gpu.cycles"), reference / value(s, "gpu.cycles"), value(s, "gpu.rt.node_visits") * 1e-6,
               value(s, "gpu.rt.node_fetches") * 1e-6, value(s, "gpu.rt.node_fetch_latency"),
               100.0 * value(s, "gpu.l1.node.hit_rate"), value(s, "gpu.l2.accesses") * 1e-6,
               value(s, "gpu.dram.bytes") * 1e-6);
  }
}

/// Speed-ups of primary and of secondary rays alone, as in the paper's figure on secondary rays.
void add_speedups_by_kind(ordered_json& results, const Comparison& comparison) {
  for (const char* kind : {"primary", "secondary"}) {
    const std::string cycles = fmt::format("gpu.rays.{}_cycles", kind);
    const double reference = value(results["designs"][comparison.reference()], cycles);
    for (const std::string& name : comparison.others()) {
      const double own = value(results["designs"][name], cycles);
      if (own > 0.0) results[fmt::format("speedup_{}", kind)][name] = reference / own;
    }
  }
}

/// Cycles and speed-ups of each frame of a sequence.
void add_frames(ordered_json& results, const Comparison& comparison, const std::string& views, std::size_t frames) {
  ordered_json& list = results["frames"];
  list["views"] = views;
  for (std::size_t i = 0; i < frames; ++i) {
    const std::string cycles = fmt::format("gpu.frame{}.cycles", i);
    const double reference = value(results["designs"][comparison.reference()], cycles);
    for (const std::string& name : comparison.names()) {
      const double own = value(results["designs"][name], cycles);
      list["cycles"][name].push_back(own);
      if (name != comparison.reference()) list["speedup"][name].push_back(reference / own);
    }
  }
}

void print_frames(const ordered_json& results, const Comparison& comparison) {
  const ordered_json& frames = results.at("frames");
  for (std::size_t i = 0; i < frames.at("cycles").at(comparison.reference()).size(); ++i) {
    fmt::print("frame {}: {} {:.0f} cycles; speed-up:", i, comparison.reference(),
               frames.at("cycles").at(comparison.reference()).at(i).get<double>());
    for (const std::string& name : comparison.others()) {
      fmt::print(" {} {:.2f}", name, frames.at("speedup").at(name).at(i).get<double>());
    }
    fmt::print("\n");
  }
}

/// Intervals of cycles and of speed-ups; the designs have the same sample.
void add_intervals(const std::map<std::string, ordered_json>& documents, const Comparison& comparison,
                   ordered_json& results) {
  const auto json = [](const ConfidenceInterval& interval) {
    return ordered_json{{"low", interval.low}, {"high", interval.high}, {"confidence", kConfidence}};
  };
  const SampledEstimate reference = estimate_from_json(documents.at(comparison.reference()).at("sampled"));
  for (const std::string& name : comparison.names()) {
    const SampledEstimate estimate = estimate_from_json(documents.at(name).at("sampled"));
    results["cycles_interval"][name] = json(cycles_interval(estimate));
    if (name != comparison.reference()) results["speedup_interval"][name] = json(ratio_interval(reference, estimate));
  }
}

void print_intervals(const ordered_json& results) {
  fmt::print("95 % intervals of the speed-ups:");
  for (const auto& [name, interval] : results.at("speedup_interval").items()) {
    fmt::print(" {} {:.2f} to {:.2f}", name, interval.at("low").get<double>(), interval.at("high").get<double>());
  }
  fmt::print("\n");
}

/// What a person wants to see of the results.
void print_summary(const RunArguments& options, const Comparison& comparison, const ordered_json& results,
                   const TracedDesigns& traced, bool free_checkpoints) {
  const bool objects = results.contains("speedup_over");
  say("{}", describe_machine(options.machine, options.config, options.settings, options.mode));
  print_table(results.at("designs"), comparison);
  if (options.mode != SimulationMode::cycle) print_intervals(results);
  if (results.contains("frames")) print_frames(results, comparison);
  for (const char* kind : {"primary", "secondary"}) {
    const std::string key = fmt::format("speedup_{}", kind);
    if (!results.contains(key)) continue;
    fmt::print("speed-up on {} rays alone:", kind);
    for (const auto& [name, speedup] : results.at(key).items()) fmt::print(" {} {:.2f}", name, speedup.get<double>());
    fmt::print("\n");
  }
  say("{}", describe_end(traced.counters));
  if (objects) fmt::print("several objects: sw and grtx alone, speed-up over {}\n", comparison.reference());
  fmt::print("images of the {} designs: {}\n", objects ? "two" : "four",
             traced.identical ? "bit-identical" : "DIFFERENT");
  if (free_checkpoints) {
    fmt::print("checkpoint traffic is free on this machine ({} charges it)\n",
               options.machine == kDefaultMachine ? kChargedMachine : "rt.checkpoint.traffic=charged");
  }
}

int run(RunArguments& options, const CommonOptions& common) {
  const bool quiet = common.quiet;
  apply_machine_tracer(*options.command, options.machine);
  const GpuConfig config = load_machine_config(options.machine, options.config, options.settings);
  const WindowOptions windows = estimate_options(options.estimate, options.mode);
  warn_of_idle_keys(config, options.mode);
  const bool objects = frontend::is_object_list(options.scene) && !options.flatten;
  const Comparison comparison(objects);
  for (const Design& design : comparison.designs()) tracer_options(options.tracer, design.checkpoint, design.accel);
  if (options.tracer.options.triangle_test == frontend::TriangleTest::world) {
    throw Error("--triangle-test", "world", "gives images that differ with the structure; run compares identical ones");
  }
  if (!options.view.views.empty() && options.mode == SimulationMode::windows) {
    throw Error("--mode", "windows", "has no caches to keep warm from frame to frame: --views needs cycle or sampled");
  }
  std::error_code failed;
  std::filesystem::create_directories(options.output, failed);
  if (failed) throw Error(options.output, "", "cannot be made a folder: " + failed.message());
  const FileLock lock(options.output + "/" + kLock, options.output, "another grtx run is filling it");

  const TracedDesigns traced = trace_designs(options, comparison, objects, common);
  remove_earlier_run(options.output);
  const std::size_t frames = traced.images.size();
  const ordered_json images = write_images(options.output, traced.images);
  if (options.mode_option->count() == 0) {
    options.mode = unnamed_mode(traced, comparison, config, windows);
  }
  std::map<std::string, ordered_json> documents =
      simulate_designs(traced.designs, comparison, config, options, windows, quiet);

  ordered_json results;
  results["schema"] = "grtx.run/1";
  results["version"] = GRTX_VERSION;
  results["model_version"] = kModelVersion;
  results["machine"] = machine_name(options.machine, config);
  results["config"] = config_json(config);
  if (objects) results["speedup_over"] = comparison.reference();  // else over the baseline
  std::vector<std::string> violations;
  std::map<std::string, ResultNotes> notes;
  for (const std::string& name : comparison.names()) {
    ordered_json& design = results["designs"][name];
    design = traced.designs.at(name).statistics;
    design.update(documents.at(name).at("stats"));
    // The command line may have named other tracer options than the machine.
    put_first(tracer_notes(options.machine, traces::Reader(traced.designs.at(name).path).header()), documents.at(name));
    results["notes"][name] = documents.at(name).at("notes");
    notes[name] = notes_from(results["notes"][name], name);
    const ordered_json& inputs = results["inputs"][name] = documents.at(name).at("inputs");
    if (inputs.value(std::string("trace.") + kFilesHash, "") != traced.files_hash) {
      throw Error(traced.designs.at(name).path, "", "was replaced by another trace while the run was under way");
    }
    results["binding_bound"][name] = documents.at(name).at("binding_bound");
    for (const auto& violation : documents.at(name).at("violations")) {
      violations.push_back(fmt::format("{}: {}", name, violation.get<std::string>()));
    }
  }
  const double reference = value(results["designs"][comparison.reference()], "gpu.cycles");
  for (const std::string& name : comparison.others()) {
    results["speedup"][name] = reference / value(results["designs"][name], "gpu.cycles");
  }
  if (options.mode != SimulationMode::cycle) add_intervals(documents, comparison, results);
  if (options.mode != SimulationMode::windows && options.tracer.secondary.what != "none") {
    add_speedups_by_kind(results, comparison);
  }
  results["images"] = images;
  if (frames > 1) add_frames(results, comparison, options.view.views, frames);
  results["images_identical"] = traced.identical;
  results["violations"] = violations;
  write_file(options.output + "/results.json", json_text(results, 1) + "\n");
  ReportOptions report;
  report.inputs = {options.output + "/results.json"};
  write_file(options.output + "/report.html", report_page(report));
  print_notes(notes);

  if (common.json) {
    print_json(results);
  } else if (!quiet) {
    print_summary(options, comparison, results, traced,
                  config.rt.checkpoint.traffic == modules::TrafficCharging::uncharged);
  }
  for (const std::string& violation : violations) fmt::print(stderr, "grtx: {}\n", violation);
  return traced.identical && violations.empty() ? 0 : 1;
}

}  // namespace

std::vector<std::string> run_files(const std::string& folder, const std::string& views) {
  std::vector<std::string> files = frame_paths(folder + "/image.png", views);
  for (const Design& design : kDesigns) files.push_back(fmt::format("{}/{}.grtx", folder, design.name));
  for (const char* name : {"results.json", "report.html", kLock}) files.push_back(folder + "/" + name);
  return files;
}

void add_run(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<RunArguments>();
  CLI::App* command = make_command(app, common, "run", "Traces and simulates baseline, sw, hw and grtx; one table",
                                   [options, &common] { return run(*options, common); });
  command->add_option("--scene", options->scene, "Scene file, or object list .json: sw and grtx alone (no default)")
      ->type_name(kInputFile)
      ->required();
  add_flatten_option(command, options->flatten);
  add_view_options(command, options->view);
  add_views_option(command, options->view);
  add_tracer_options(command, options->tracer);
  options->command = command;
  add_machine_option(command, options->machine);
  command->add_option("--config", options->config, "Configuration file: what differs from the machine (default: none)")
      ->type_name(kInputFile);
  command->add_option("--set", options->settings, "Configuration key=value; repeatable (default: none)");
  options->mode_option = add_mode_option(command, options->mode, "Which events take time, as in grtx sim")
                             ->default_str("cycle; of full frames windows, which a line says");
  add_estimate_options(command, options->estimate);
  command->add_option(
      "--jobs", options->jobs,
      "Simulations at a time, each a process of its own; 0: one a core, while there is memory for each");
  command
      ->add_option("-o,--output", options->output,
                   "Folder for results.json, report.html, image.png and the traces (no default)")
      ->type_name(kOutputFile)
      ->required();
}

}  // namespace grtx::sim
