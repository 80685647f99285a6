// SPDX-License-Identifier: Apache-2.0
// grtx run: the main job. Traces one view with the designs, simulates each, and compares.
#include <fmt/format.h>

#include <memory>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/estimate_cli.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/apps/grtx/tracer_cli.h"
#include "grtx/experiment/machine.h"
#include "grtx/experiment/option_text.h"
#include "grtx/experiment/picture_quality.h"
#include "grtx/experiment/run_designs.h"
#include "grtx/experiment/tracer_statistics.h"

namespace grtx::apps {
namespace {

using nlohmann::ordered_json;

constexpr const char* kChargedMachine = "paper-charged";  ///< the default machine with every byte charged

struct RunArguments {
  experiment::RunPlan plan;
  CLI::App* command = nullptr;
  std::string config;
  std::vector<std::string> settings;
  sim::SimulationMode mode = sim::SimulationMode::cycle;
  CLI::Option* mode_option = nullptr;  ///< the --mode option; tells whether it was given
  EstimateCli estimate;
};

double value(const ordered_json& statistics, const std::string& name) {
  return statistics.at(name).at("value").get<double>();
}

void print_table(const ordered_json& designs, const experiment::DesignComparison& comparison) {
  // 80 columns; visits, fetches and L2 accesses in millions.
  fmt::print("{:<9} {:>10} {:>8} {:>8} {:>9} {:>7} {:>6} {:>8} {:>7}\n", "design", "cycles", "speed-up", "visits M",
             "fetches M", "latency", "L1 hit", "L2 M", "DRAM MB");
  const double reference = value(designs.at(comparison.reference()), "gpu.cycles");
  for (const std::string& name : comparison.names()) {
    const ordered_json& s = designs.at(name);
    fmt::print("{:<9} {:>10.0f} {:>8.2f} {:>8.3f} {:>9.3f} {:>7.1f} {:>5.1f}% {:>8.3f} {:>7.1f}\n", name,
               value(s, "gpu.cycles"), reference / value(s, "gpu.cycles"), value(s, "gpu.rt.node_visits") * 1e-6,
               value(s, "gpu.rt.node_fetches") * 1e-6, value(s, "gpu.rt.node_fetch_latency"),
               100.0 * value(s, "gpu.l1.node.hit_rate"), value(s, "gpu.l2.accesses") * 1e-6,
               value(s, "gpu.dram.bytes") * 1e-6);
  }
}

void print_frames(const ordered_json& results, const experiment::DesignComparison& comparison) {
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

void print_intervals(const ordered_json& results) {
  std::string text = "95 % intervals of the speed-ups:";
  for (const auto& [name, interval] : results.at("speedup_interval").items()) {
    text +=
        fmt::format(" {} {:.2f} to {:.2f}", name, interval.at("low").get<double>(), interval.at("high").get<double>());
  }
  say("{}", text);
}

void print_images(const experiment::DesignResults& run) {
  const ordered_json orders = run.json.value("other_orders", ordered_json::object());
  const std::size_t alike = run.comparison.names().size() - orders.size();
  if (alike > 1) {
    fmt::print("images of the {} designs{}: {}\n", alike, orders.empty() ? "" : " that blend in one order",
               run.images_identical ? "bit-identical" : "DIFFERENT");
  }
  for (const auto& [name, order] : orders.items()) {
    fmt::print("image of {}: blended by {}, {:.1f} dB from {}\n", name, order.at("order").get<std::string>(),
               order.at("psnr").get<double>(), run.comparison.reference());
  }
  std::string text = "images against the fp64 reference in the order of each design, worst frame:";
  for (const std::string& name : run.comparison.names()) {
    const ordered_json& picture = run.json.at("pictures").at(name);
    const bool fp64 = picture.at("reference") == "fp64";
    text += fmt::format(" {} {}{}", name, experiment::worst_picture(picture.at("psnr_reference")),
                        fp64 ? "" : " (against the tracer at full precision)");
  }
  say("{}", text);
}

/// Prints a summary of the results.
void print_summary(const RunArguments& options, const experiment::DesignResults& run) {
  const ordered_json& results = run.json;
  const experiment::DesignComparison& comparison = run.comparison;
  const std::string& machine = options.plan.machine;
  const bool objects = results.contains("speedup_over");
  say("{}", experiment::describe_machine(machine, options.config, options.settings, run.mode));
  print_table(results.at("designs"), comparison);
  if (run.mode != sim::SimulationMode::cycle) print_intervals(results);
  if (results.contains("frames")) print_frames(results, comparison);
  for (const char* kind : {"primary", "secondary"}) {
    const std::string key = fmt::format("speedup_{}", kind);
    if (!results.contains(key)) continue;
    fmt::print("speed-up on {} rays alone:", kind);
    for (const auto& [name, speedup] : results.at(key).items()) fmt::print(" {} {:.2f}", name, speedup.get<double>());
    fmt::print("\n");
  }
  say("{}", experiment::describe_end(run.counters));
  if (objects) fmt::print("speed-up over {}\n", comparison.reference());
  print_images(run);
  if (options.plan.config.rt.checkpoint.traffic == modules::TrafficCharging::uncharged) {
    fmt::print("checkpoint traffic is free on this machine ({} charges it)\n",
               machine == experiment::kDefaultMachine ? kChargedMachine : "rt.checkpoint.traffic=charged");
  }
}

int run(RunArguments& options, const CommonOptions& common) {
  experiment::RunPlan& plan = options.plan;
  experiment::ChosenMachine chosen =
      choose_machine({.machine = plan.machine, .config = options.config, .settings = options.settings}, common, false);
  apply_tracer(plan.tracer, chosen, *options.command);
  plan.config = std::move(chosen.config);  // checked with the keys of each design
  plan.chosen_tracer = std::move(chosen.tracer);
  plan.machine_hash = std::move(chosen.machine_hash);
  plan.named = explore::keys_of(options.settings);
  for (const experiment::TracerOptionName& option : experiment::tracer_option_names()) {
    if (options.command->count(experiment::flag_of(option.key)) > 0) plan.named.insert(option.key);
  }
  plan.windows = estimate_options(options.estimate, options.mode);
  if (options.mode_option->count() > 0) plan.mode = options.mode;
  plan.quiet = common.quiet;
  plan.opened = [&common](const FilesRead& files) { common.files.check(files); };
  const experiment::DesignResults results = experiment::run_designs(plan);
  sim::print_notes(results.notes);
  if (common.json) {
    print_json(results.json);
  } else if (!common.quiet) {
    print_summary(options, results);
  }
  for (const std::string& violation : results.violations) fmt::print(stderr, "grtx: {}\n", violation);
  return results.sound() ? 0 : 1;
}

}  // namespace

void add_run(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<RunArguments>();
  CLI::App* command = make_command(app, common, "run", "Traces and simulates designs side by side; one table",
                                   [options, &common] { return run(*options, common); });
  command
      ->add_option("--scene", options->plan.scene,
                   "Scene file, or object list .json: of the designs, sw and grtx alone (no default)")
      ->type_name(kInputFile)
      ->required();
  command
      ->add_option("--designs", options->plan.designs,
                   "Designs to compare, with commas; speed-ups are over the first of the table (default: all but walk)")
      ->delimiter(',')
      ->check(one_of(explore::design_names()));
  add_flatten_option(command, options->plan.flatten);
  add_view_options(command, options->plan.view);
  add_views_option(command, options->plan.view);
  add_tracer_options(command, options->plan.tracer);
  options->command = command;
  add_machine_option(command, options->plan.machine);
  command->add_option("--config", options->config, "Configuration file: what differs from the machine (default: none)")
      ->type_name(kInputFile);
  command->add_option("--set", options->settings, "Configuration key=value; repeatable (default: none)");
  options->mode_option = add_mode_option(command, options->mode, "Which events take time, as in grtx sim")
                             ->default_str("cycle; windows for full frames, as a line then says");
  add_estimate_options(command, options->estimate);
  command->add_option(
      "--jobs", options->plan.jobs,
      "Simulations at a time, each a process of its own; 0: one per core, while there is memory for each");
  command
      ->add_option("-o,--output", options->plan.output,
                   "Folder for results.json, report.html, image.png and the traces (no default)")
      ->type_name(kOutputFile)
      ->required();
}

}  // namespace grtx::apps
