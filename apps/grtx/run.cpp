// SPDX-License-Identifier: Apache-2.0
// grtx run: the main job. Traces one view with the designs, simulates each on one machine or several, and compares.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <tuple>
#include <utility>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/estimate_cli.h"
#include "grtx/apps/grtx/help_format.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/apps/grtx/results_file.h"
#include "grtx/apps/grtx/tracer_cli.h"
#include "grtx/experiment/machine.h"
#include "grtx/experiment/option_text.h"
#include "grtx/experiment/picture_quality.h"
#include "grtx/experiment/run_designs.h"
#include "grtx/experiment/tracer_statistics.h"
#include "grtx/explore/sweep/axis.h"
#include "grtx/report/page/launch_size.h"
#include "grtx/report/page/machine_words.h"

namespace grtx::apps {
namespace {

using nlohmann::ordered_json;

constexpr const char* kChargedMachine = "paper-charged";  ///< the default machine with every byte charged

struct RunArguments {
  experiment::RunPlan plan;
  CLI::App* command = nullptr;
  std::vector<std::string> machines = {experiment::kDefaultMachine};
  std::string config;
  std::vector<std::string> settings;
  sim::SimulationMode mode = sim::SimulationMode::cycle;
  CLI::Option* mode_option = nullptr;  ///< the --mode option; tells whether it was given
  EstimateCli estimate;
};

/// Hits of a round of a design, as its trace has them.
std::string k_of(const ordered_json& results, const std::string& design) {
  return results.at("inputs").at(design).value("trace.k", "");
}

void print_table(const ordered_json& results, const experiment::DesignComparison& comparison) {
  // 80 columns; visits, fetches and L2 accesses in millions.
  const ordered_json& designs = results.at("designs");
  fmt::print("{:<9} {:>3} {:>9} {:>8} {:>8} {:>7} {:>7} {:>7} {:>6} {:>7}\n", "design", "k", "cycles", "speed-up",
             "visits M", "fetch M", "latency", "L1 node", "L2 M", "DRAM MB");
  const std::string& over = comparison.reference();
  const double reference = statistic_value(designs.at(over), "gpu.cycles");
  std::string other_k;
  for (const std::string& name : comparison.names()) {
    const ordered_json& s = designs.at(name);
    const std::string k = k_of(results, name);
    if (k != k_of(results, over)) other_k += fmt::format("{}{} at {}", other_k.empty() ? "" : ", ", name, k);
    const auto shown = [&s](const char* statistic, double scale, int decimals, const char* unit = "") {
      return shown_value(scale * statistic_value(s, statistic), decimals, unit);
    };
    fmt::print("{:<9} {:>3} {:>9.0f} {:>8.2f} {:>8} {:>7} {:>7} {:>7} {:>6} {:>7}\n", name, k,
               statistic_value(s, "gpu.cycles"), reference / statistic_value(s, "gpu.cycles"),
               shown("gpu.rt.node_visits", 1e-6, 3), shown("gpu.rt.node_fetches", 1e-6, 3),
               shown("gpu.rt.node_fetch_latency", 1.0, 1), shown("gpu.l1.node.hit_rate", 100.0, 1, "%"),
               shown("gpu.l2.accesses", 1e-6, 3), shown("gpu.dram.bytes", 1e-6, 1));
  }
  if (!other_k.empty()) {
    say("speed-ups are over {} at k = {}; {} (--k sets one for all)", over, k_of(results, over), other_k);
  } else if (over != explore::design_names().front() && !comparison.others().empty()) {
    say("speed-ups are over {}", over);
  }
}

void print_frames(const ordered_json& results, const experiment::DesignComparison& comparison) {
  const ordered_json& frames = results.at("frames");
  say("cycles, visits, fetches, accesses and bytes are of all {} frames",
      frames.at("cycles").at(comparison.reference()).size());
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
  for (const auto& [key, what, decimals] :
       {std::tuple("cycles_interval", "cycles", 0), std::tuple("speedup_interval", "speed-ups", 2)}) {
    if (!results.contains(key)) continue;
    std::string text = fmt::format("95 % intervals of the {}:", what);
    for (const auto& [name, interval] : results.at(key).items()) {
      text += fmt::format(" {} {:.{}f} to {:.{}f}", name, interval.at("low").get<double>(), decimals,
                          interval.at("high").get<double>(), decimals);
    }
    say("{}", text);
  }
  for (const auto& [name, statistics] : results.at("designs").items()) {
    if (statistics.contains("gpu.l2.accesses")) continue;
    return say("-: latency, hit rates and traffic are counted in cycle mode alone");
  }
}

void print_images(const experiment::DesignResults& run) {
  const ordered_json orders = run.json.value("other_orders", ordered_json::object());
  const std::size_t alike = run.comparison.names().size() - orders.size();
  if (alike > 1) {
    fmt::print("images of the {} designs{}: {}\n", alike, orders.empty() ? "" : " that blend in one order",
               run.images_identical ? "bit-identical" : "DIFFERENT");
  }
  for (const auto& [name, order] : orders.items()) {
    const ordered_json& own = run.json.at("pictures").at(name).at("psnr");
    const std::string worst = experiment::worst_picture(own);
    say("{} blends by {}: {} {}{}", name, order.at("order").get<std::string>(),
        worst == "identical" ? worst + " to" : worst + " from", run.comparison.reference(),
        own.size() == 1 ? "" : ", worst frame");
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

/// The launches of all designs on a machine of results.json. machine: its name; "" where there is one.
std::vector<report::LaunchSize> launches_of(const ordered_json& results, const experiment::DesignComparison& comparison,
                                            const std::string& machine) {
  std::vector<report::LaunchSize> launches;
  for (const std::string& design : comparison.names()) {
    const ordered_json one = statistics_of(results, "results.json", design, machine);
    launches.push_back(report::launch_size(one.at("stats"), one.at("config"), one.at("inputs")));
  }
  return launches;
}

void print_too_small(const std::vector<report::LaunchSize>& launches, const char* what) {
  const std::string small = report::too_small_text(launches, what);
  if (!small.empty()) say("mind: {}", small);
}

/// Times of each design on each machine, over the first, which design loses most, and the keys in which machines
/// differ.
void print_between(const ordered_json& results, const experiment::DesignComparison& comparison,
                   const std::vector<std::string>& names) {
  constexpr std::size_t kColumn = 22;
  const ordered_json &machines = results.at("machines"), &between = results.at("between_machines");
  double longest = 0.0;
  std::vector<report::LaunchSize> launches;
  for (std::size_t m = 0; m < names.size(); ++m) {
    const std::vector<report::LaunchSize> own =
        launches_of(results, comparison, machines[m].at("machine").get<std::string>());
    launches.insert(launches.end(), own.begin(), own.end());
    for (const std::string& design : comparison.names()) {
      longest = std::max(longest, statistic_value(machines[m].at("designs").at(design), "gpu.time_us"));
    }
  }
  const std::size_t frames = report::frames_of(machines.front().at("designs").at(comparison.reference()));
  const auto [unit, scale] = longest < 1e3 ? std::pair("us", 1.0) : std::pair("ms", 1e-3);
  fmt::print("\ntimes{} in {}, in brackets how many times as fast as on {}\n{:<9}",
             frames == 1 ? "" : fmt::format(" of all {} frames", frames), unit, names.front(), "design");
  for (const std::string& name : names) fmt::print(" {:>{}}", name, kColumn);
  fmt::print("\n");
  for (const std::string& design : comparison.names()) {
    fmt::print("{:<9}", design);
    for (const ordered_json& machine : machines) {
      std::string cell =
          fmt::format("{:.3f}", scale * statistic_value(machine.at("designs").at(design), "gpu.time_us"));
      if (&machine != &machines.front()) {
        const auto its = machine.at("machine").get<std::string>();
        cell += fmt::format(" ({:.2f})", between.at("speedup").at(its).at(design).get<double>());
      }
      fmt::print(" {:>{}}", cell, kColumn);
    }
    fmt::print("\n");
  }
  for (std::size_t m = 1; m < names.size(); ++m) {
    std::vector<std::pair<std::string, double>> times;
    for (const auto& [design, ratio] : between.at("speedup").at(machines[m].at("machine").get<std::string>()).items()) {
      times.emplace_back(design, ratio.get<double>());
    }
    say("{}", report::loses_most_text(times, names[m], names.front()));
  }
  print_too_small(launches, "machines");
  const ordered_json& keys = between.at("keys");
  fmt::print("\n{} keys and options of the tracer differ\n{:<31}", keys.size(), "key");
  for (const std::string& name : names) fmt::print(" {:>19}", name);
  fmt::print("\n");
  for (const auto& [key, values] : keys.items()) {
    fmt::print("{:<31}", key);
    for (std::size_t m = 0; m < names.size(); ++m) {
      const ordered_json& config = machines[m].at("config");
      fmt::print(" {:>19}", config.contains(key) ? report::key_text(config, key) : explore::text_of(values[m]));
    }
    fmt::print("\n");
  }
}

/// Prints the results of one machine. machine: as it was asked for.
void print_machine(const RunArguments& options, const std::string& machine, const ordered_json& results,
                   const experiment::DesignResults& run) {
  const experiment::DesignComparison& comparison = run.comparison;
  say("{}", experiment::describe_machine(machine, options.config, options.settings, run.mode));
  print_table(results, comparison);
  if (run.comparison.names().size() > 1) print_too_small(launches_of(results, comparison, ""), "designs");
  if (run.mode != sim::SimulationMode::cycle) print_intervals(results);
  if (results.contains("frames")) print_frames(results, comparison);
  for (const char* kind : {"primary", "secondary"}) {
    const std::string key = fmt::format("speedup_{}", kind);
    if (!results.contains(key)) continue;
    fmt::print("speed-up on {} rays alone:", kind);
    for (const auto& [name, speedup] : results.at(key).items()) fmt::print(" {} {:.2f}", name, speedup.get<double>());
    fmt::print("\n");
  }
}

/// Prints a summary of the results.
void print_summary(const RunArguments& options, const experiment::DesignResults& run) {
  const ordered_json& results = run.json;
  const experiment::DesignComparison& comparison = run.comparison;
  const std::vector<experiment::MachinePlan> machines = machines_of(options.plan);
  std::vector<std::string> names;
  for (std::size_t m = 0; m < machines.size(); ++m) {
    names.push_back(experiment::machine_name(machines[m].machine));
    if (m > 0) fmt::print("\n");
    print_machine(options, machines[m].machine, machines.size() == 1 ? results : results.at("machines")[m], run);
  }
  if (machines.size() > 1) print_between(results, comparison, names);
  say("{}", experiment::describe_end(run.counters));
  print_images(run);
  for (std::size_t m = 0; m < machines.size(); ++m) {
    if (machines[m].config.rt.checkpoint.traffic != modules::TrafficCharging::uncharged) continue;
    fmt::print("checkpoint traffic is free on {} ({} charges it)\n", machines.size() == 1 ? "this machine" : names[m],
               machines[m].machine == experiment::kDefaultMachine ? kChargedMachine : "rt.checkpoint.traffic=charged");
  }
}

int run(RunArguments& options, const CommonOptions& common) {
  experiment::RunPlan& plan = options.plan;
  const experiment::TracerSettings asked = plan.tracer;
  std::vector<experiment::MachinePlan> machines;
  for (const std::string& machine : options.machines) {
    experiment::ChosenMachine chosen =
        choose_machine({.machine = machine, .config = options.config, .settings = options.settings}, common, false);
    experiment::MachinePlan& own = machines.emplace_back();
    own.machine = machine;
    own.tracer = asked;
    apply_tracer(own.tracer, chosen, *options.command);
    own.config = std::move(chosen.config);  // checked with the keys of each design
    own.chosen_tracer = std::move(chosen.tracer);
    own.machine_hash = std::move(chosen.machine_hash);
  }
  static_cast<experiment::MachinePlan&>(plan) = machines.front();
  plan.further.assign(machines.begin() + 1, machines.end());
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
  add_flatten_option(command, options->plan.flatten);
  add_view_options(command, options->plan.view);
  add_views_option(command, options->plan.view);
  command
      ->add_option("--designs", options->plan.designs,
                   "Designs to compare, with commas; speed-ups are over the first of the table (default: all, but "
                   "those that refuse an option)")
      ->delimiter(',')
      ->check(one_of(explore::design_names()));
  add_tracer_options(command, options->plan.tracer);
  for (const explore::Design& design : explore::designs()) {
    for (const auto& [name, value] : design.tracer) {
      command->get_option(experiment::flag_of(name))->default_str("each design's own (docs/guide/designs.md)");
    }
  }
  options->command = command;
  add_machine_option(command, options->machines);
  command->add_option("--config", options->config, "Configuration file: what differs from the machine (default: none)")
      ->type_name(kInputFile);
  command->add_option("--set", options->settings, "Configuration key=value; repeatable (default: none)");
  options->mode_option = add_mode_option(command, options->mode, "Which events take time, as in grtx sim")
                             ->default_str("cycle; windows for full frames, as a line then says");
  add_estimate_options(command, options->estimate);
  command->add_flag(
      "--latency", options->plan.latency,
      "Where reads spend their time, by level of the memory, also on the page; mode cycle (default: off)");
  command->add_option(
      "--jobs", options->plan.jobs,
      "Simulations at a time, each a process of its own; 0: one per core, while there is memory for each");
  command
      ->add_option("-o,--output", options->plan.output,
                   "Folder for results.json, report.html, image.png and the traces (no default)")
      ->type_name(kOutputFile)
      ->required();
  group_options(
      command,
      {{"Scene", {"--scene", "--flatten", "--secondary"}},
       {"View", {"--cameras", "--view", "--views", "--width", "--height", "--fov-scale"}},
       {"Structure", {"--designs", "--layout", "--bvh-width", "--instance-bounds"}},
       {"Rounds",
        {"--k", "--ert", "--sort-key", "--child-order", "--tmax-update", "--opacity-bound", "--checkpoint-bins"}},
       {"Machine", {"--machine", "--config", "--set", "--mode", "--target-error", "--latency", "--jobs"}},
       {"Output", {"--output"}}});
}

}  // namespace grtx::apps
