// SPDX-License-Identifier: Apache-2.0
// grtx sim: runs a trace on the hardware model.
#include "grtx/rtl_tlm/observe/observation.h"
#include "grtx/rtl_tlm/run/simulation.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/estimate_cli.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/apps/grtx/results_file.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/experiment/heatmap.h"
#include "grtx/experiment/machine.h"
#include "grtx/experiment/machine_notes.h"
#include "grtx/experiment/simulate_mode.h"
#include "grtx/explore/cost/energy_statistics.h"
#include "grtx/explore/sweep/designs.h"
#include "grtx/rtl_tlm/estimate/windows/window_refusal.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/idle_keys.h"
#include "grtx/rtl_tlm/observe/timeline_size.h"
#include "grtx/rtl_tlm/run/statistics_json.h"
#include "grtx/rtl_tlm/run/statistics_reference.h"

namespace grtx::apps {
namespace {

struct SimArguments {
  std::string trace;
  experiment::MachineChoice machine;
  std::string statistics;
  sim::SimulationMode mode = sim::SimulationMode::cycle;
  std::string window;
  std::string timeline_window;
  std::vector<std::string> heatmaps;
  bool list_config = false;
  bool list_statistics = false;
  bool no_idle_skip = false;
  bool strict = false;
  EstimateCli estimate;
  sim::SimulationOptions simulation;
};

double number(const nlohmann::ordered_json& document, const char* name) {
  return statistic_value(document.at("stats"), name);
}

void print_summary(const SimArguments& options, const sim::SimulationResult& result) {
  const nlohmann::ordered_json& d = result.document;
  const experiment::MachineChoice& m = options.machine;
  say("{}{}", experiment::describe_machine(m.machine, m.config, m.settings, options.mode),
      m.design.empty() ? "" : ", with units of design " + m.design);
  const auto shown = [&d](const char* name, double scale, int decimals) {
    return shown_value(scale * number(d, name), decimals);
  };
  say("{} cycles, {:.1f} us at {} MHz; largest lower bound {} ({} % of the time)", result.cycles,
      number(d, "gpu.time_us"), json_text(d.at("config").at("gpu.core_mhz")), result.binding_bound,
      shown("gpu.bound.fraction", 100.0, 0));
  say("{} node visits in {} fetches, {} cycles each; L1 node hit rate {} %, L2 {} %",
      shown("gpu.rt.node_visits", 1.0, 0), shown("gpu.rt.node_fetches", 1.0, 0),
      shown("gpu.rt.node_fetch_latency", 1.0, 1), shown("gpu.l1.node.hit_rate", 100.0, 1),
      shown("gpu.l2.hit_rate", 100.0, 1));
  say("host: {:.2f} s ({:.2f} s of CPU), {:.3g} node visits/s, {:.3g} SM-cycles/s, slowdown {:.3g}, {:.0f} MB",
      number(d, "host.wall_seconds"), number(d, "host.cpu_seconds"), number(d, "host.node_visits_per_second"),
      number(d, "host.sm_cycles_per_second"), number(d, "host.slowdown"), number(d, "host.peak_rss_bytes") * 1e-6);
}

int report_faults(const sim::SimulationResult& result) {
  sim::print_notes({{"sim", sim::notes_from(result.document.at("notes"), "sim")}});
  for (const std::string& violation : result.violations) {
    fmt::print(stderr, "grtx: sim: conservation law violated: {}\n", violation);
  }
  return result.violations.empty() ? 0 : 1;
}

/// Notes on a trace that was made for another machine, or for units that this one lacks; with --strict throws Error for
/// the former.
sim::ResultNotes notes_before(const SimArguments& options, const experiment::ChosenMachine& chosen) {
  const traces::Reader reader(options.trace);
  const explore::Design* design =
      options.machine.design.empty() ? nullptr : &explore::design_of(options.machine.design);
  sim::ResultNotes others = experiment::tracer_notes(options.machine.machine, chosen.tracer, design, reader.header());
  if (options.strict && !others.empty()) throw Error(options.trace, "header", others.front().text);
  const sim::ResultNotes lacking =
      experiment::design_notes(reader.header(), chosen.config, explore::keys_of(options.machine.settings));
  others.insert(others.end(), lacking.begin(), lacking.end());
  return others;
}

/// Prints the requested list of keys or statistics as Markdown. Returns false if none is requested.
bool print_list(const SimArguments& options, const CommonOptions& common) {
  if (common.json && (options.list_config || options.list_statistics)) {
    throw Error("--json", "", "needs a trace: lists are Markdown");
  }
  if (options.list_config) {
    fmt::print("{}", sim::config_reference());
    return true;
  }
  if (!options.list_statistics) return false;
  modules::StatisticList all = sim::all_statistics();
  explore::describe_energy({}, {}, 0, all);
  fmt::print("{}", sim::statistics_reference(all));
  return true;
}

int run_simulation(SimArguments options, const CommonOptions& common) {
  if (print_list(options, common)) return 0;
  if (options.trace.empty()) throw Error("sim", "TRACE", "a trace file is needed");
  const sim::WindowOptions windows = estimate_options(options.estimate, options.mode);
  if (!options.machine.design.empty()) {
    const traces::Reader reader(options.trace);
    experiment::check_design(options.trace, reader.header(), explore::design_of(options.machine.design));
    options.machine.k = reader.header().k;
  }
  const experiment::ChosenMachine chosen = choose_machine(options.machine, common);
  const sim::GpuConfig& config = chosen.config;
  sim::warn_of_idle_keys(config);
  sim::check_mode(config, options.mode);
  sim::check_mode(options.simulation, !options.heatmaps.empty(), options.mode);
  if (!options.window.empty()) options.simulation.waveform.window = sim::parse_window("--vcd-window", options.window);
  if (!options.timeline_window.empty()) {
    options.simulation.timeline.window = sim::parse_window("--timeline-window", options.timeline_window);
  }
  const std::vector<experiment::HeatmapRequest> heatmaps = experiment::heatmap_requests(options.heatmaps, {"cycles"});
  options.simulation.pixel_cycles = !heatmaps.empty();
  options.simulation.quiet = common.quiet;
  options.simulation.price = explore::describe_energy;
  options.simulation.build.idle_skip = !options.no_idle_skip;
  const sim::ResultNotes notes = notes_before(options, chosen);
  if (!common.quiet) {
    const std::uint64_t visits = traces::Reader(options.trace).totals().visits();
    experiment::say_simulation_time("sim", options.mode, visits, windows.share, experiment::kMachineBytes, 1);
  }
  sim::EstimatedResult estimate =
      experiment::simulate_in_mode(options.mode, options.trace, config, options.simulation, windows);
  sim::SimulationResult& result = estimate.result;
  experiment::put_first(notes, result.document);
  result.document["inputs"]["machine"] = chosen.name;
  const std::string large = sim::large_timeline_warning(options.simulation.timeline.path);
  if (!large.empty()) fmt::print(stderr, "grtx: sim: {}\n", large);
  if (!options.statistics.empty()) write_file(options.statistics, sim::statistics_text(result.document));
  for (const experiment::HeatmapRequest& heatmap : heatmaps) {
    experiment::write_heatmap(heatmap.path, {heatmap.name,
                                             "of a ray's warp",
                                             result.width,
                                             result.height,
                                             {result.pixel_cycles.begin(), result.pixel_cycles.end()}});
  }
  if (common.json) {
    print_json(result.document);
  } else if (!common.quiet) {
    print_summary(options, result);
    print_interval(estimate);
  }
  return report_faults(result);
}

/// Options on the contents of caches and DRAM rows before and after the run.
void add_warming_options(CLI::App* command, SimArguments& options) {
  command
      ->add_option("--warm", options.simulation.warm_trace,
                   "Trace that runs before, to warm caches and DRAM rows (default: none)")
      ->type_name(kInputFile);
  command
      ->add_option("--save-state", options.simulation.save_state,
                   "File to write, with the contents of caches and DRAM rows after the run (default: none)")
      ->type_name(kOutputFile);
  command
      ->add_option("--warm-state", options.simulation.warm_state,
                   "File of --save-state from which the run begins, in place of --warm (default: none)")
      ->type_name(kInputFile);
}

/// Options of waveform, timeline and heat map.
void add_observation_options(CLI::App* command, SimArguments& options) {
  command->add_option("--vcd", options.simulation.waveform.path, "Waveform to write (default: none)")
      ->type_name(kOutputFile);
  command->add_option(
      "--vcd-scope", options.simulation.waveform.scope,
      "Shell patterns, separated by commas, of the signals or scopes in the waveform: sm0.rt*,l2_slice0");
  command->add_option("--vcd-window", options.window, "Core cycles A:B in the waveform (default: all)");
  add_choice(command, "--vcd-level", options.simulation.waveform.level,
             "units: their state and levels; signals: also warps, slots, links");
  command
      ->add_option(
          "--timeline", options.simulation.timeline.path,
          "Timeline to write for ui.perfetto.dev: .pftrace, less than half as large, or .json, which grtx ray reads; "
          ".svg is a picture of it (default: none)")
      ->type_name(kOutputFile);
  command->add_option("--timeline-window", options.timeline_window, "Core cycles A:B in the timeline (default: all)");
  command->add_flag("--latency", options.simulation.latency,
                    "Where reads spend their time, by level of the memory: gpu.latency.* (default: off)");
  add_heatmap_option(command, options.heatmaps, {"cycles"});
}

}  // namespace

void add_sim(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<SimArguments>();
  CLI::App* command = make_command(app, common, "sim", "Runs a trace on the hardware model",
                                   [options, &common] { return run_simulation(*options, common); });
  command->add_option("TRACE", options->trace, "Trace file (no default)")->type_name(kInputFile);
  add_machine_option(command, options->machine.machine);
  command
      ->add_option("--config", options->machine.config,
                   "Configuration file: what differs from the machine (default: none)")
      ->type_name(kInputFile);
  command->add_option("--set", options->machine.settings, "key=value, after the file; may be repeated (default: none)")
      ->allow_extra_args(false);
  command
      ->add_option(
          "--design", options->machine.design,
          "Design of the trace, whose own keys are set: its units and their sizes, after the file, before --set "
          "(default: none)")
      ->check(one_of(explore::design_names()));
  command->add_flag("--strict", options->strict,
                    "Refuse a trace that was not made with the machine's tracer options (default: off)");
  command->add_option("--stats", options->statistics, "Statistics JSON to write (default: none)")
      ->type_name(kOutputFile);
  add_mode_option(command, options->mode, "Warps to simulate: all, or (whole frames) windows of them");
  add_estimate_options(command, options->estimate);
  add_warming_options(command, *options);
  add_observation_options(command, *options);
  command
      ->add_option("--watchdog", options->simulation.watchdog_cycles,
                   "Cycles without progress, or anything scheduled for later, that count as deadlock")
      ->check(above_zero());
  command->add_option("--construction-order", options->simulation.build.construction_order,
                      "Seed that shuffles the construction of the modules; 0 keeps the order. Results never change");
  command->add_flag("--no-idle-skip", options->no_idle_skip, "Tick every cycle. Results never change (default: off)");
  command->add_flag("--list-config", options->list_config, "Print all configuration keys as Markdown (default: off)");
  command->add_flag("--list-statistics", options->list_statistics, "Print all statistics as Markdown (default: off)");
}

}  // namespace grtx::apps
