// SPDX-License-Identifier: Apache-2.0
// grtx cost: storage, area, timing and leakage of the machine that a configuration describes.
#include <fmt/format.h>

#include <initializer_list>
#include <memory>
#include <optional>
#include <string>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/energy_table.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/apps/grtx/results_file.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/experiment/machine.h"
#include "grtx/experiment/machine_notes.h"
#include "grtx/experiment/option_rules.h"
#include "grtx/explore/cost/cost_report.h"
#include "grtx/explore/cost/run_energy.h"
#include "grtx/explore/cost/run_machine.h"
#include "grtx/explore/cost/technology.h"
#include "grtx/explore/sweep/designs.h"
#include "grtx/explore/sweep/points.h"
#include "grtx/frontend/gaussian/hit_options.h"
#include "grtx/report/page/run_results.h"
#include "grtx/rtl_tlm/gpu/machine.h"
#include "grtx/rtl_tlm/run/statistics_json.h"
#include "grtx/traces/checkpoint_bins.h"

namespace grtx::apps {
namespace {

struct CostArguments {
  experiment::MachineChoice machine;
  sim::MachineUse use;
  frontend::SortKey sort_key = frontend::SortKey::entry;
  explore::CostOptions cost;
  explore::BufferSizes buffers;
  unsigned depth = 3;
  bool items = false;
  std::string csv;
  std::string statistics;
  explore::EnergyOptions energy;
  bool coefficients = false;
  CLI::App* command = nullptr;
};

/// The energy of a run of the configured machine.
void print_energy(const CostArguments& options, const nlohmann::ordered_json& document, const sim::GpuConfig& config,
                  const std::vector<modules::Inventory>& inventories, bool as_json) {
  if (document.at("inputs").value("config_hash", "") != sim::config_hash(config)) {
    const std::string design = experiment::design_with_units(experiment::traced_inputs(document.at("inputs")));
    throw Error(options.statistics, "inputs.config_hash",
                fmt::format("is of another configuration than --machine, --config, --design and --set give{}",
                            options.machine.design.empty() && !design.empty()
                                ? fmt::format("; its trace is of --design {}", design)
                                : ""));
  }
  const nlohmann::ordered_json& stats = document.at("stats");
  const auto value = [&](const std::string& name) {
    const bool counted = stats.contains(name) && stats.at(name).at("value").is_number();
    return counted ? std::optional(stats.at(name).at("value").get<double>()) : std::nullopt;
  };
  const std::vector<explore::EnergyPart> parts =
      explore::run_energy(value, config, inventories, options.cost, options.energy, options.statistics);
  if (!options.csv.empty()) write_file(options.csv, explore::energy_csv(parts));
  if (as_json) {
    print_json(explore::energy_json(parts, report::frames_of(stats)));
  } else {
    fmt::print("{}", explore::energy_text(parts, report::frames_of(stats)));
  }
}

/// Options not given on the command line are taken from the tracer options of the machine and, over them, the design.
void choose_for(const CostArguments& options, const experiment::ChosenMachine& machine, sim::MachineUse& use) {
  std::map<std::string, std::string> chosen = explore::tracer_of(explore::design_of(use.design), machine.tracer, {});
  for (const char* named : {"pop_test", "any_hit", "sort_key", "opacity_bound", "layout", "bvh_width",
                            "checkpoint_bins", "checkpoint_capacity"}) {
    if (options.command->count(experiment::flag_of(named)) > 0) chosen.erase(named);
  }
  explore::choose_nodes_and_lists(chosen, options.machine.machine, use);
}

/// --design beside --stats: the design that the run's trace is of, with its k.
void take_design_of(const nlohmann::ordered_json& inputs, CostArguments& options) {
  const explore::Design& design = explore::design_of(options.use.design);
  const std::map<std::string, std::string> traced = experiment::traced_inputs(inputs);
  experiment::check_design(options.statistics, "inputs", traced, design);
  options.machine.design = design.name;
  if (traced.contains("k")) options.machine.k = explore::k_of(design, traced.at("k"));
}

void refuse_own_machine(const CostArguments& options) {
  for (const char* option : {"--config", "--set"}) {
    if (options.command->count(option) > 0) throw Error("cost", option, "results.json has the machine of the run");
  }
}

/// The run of a design in results.json, which has its whole machine.
nlohmann::ordered_json one_of_results(const nlohmann::ordered_json& results, const CostArguments& options) {
  refuse_own_machine(options);
  const auto named = [&](const char* option, const std::string& text) {
    return options.command->count(option) > 0 ? text : std::string();
  };
  return statistics_of(results, options.statistics, named("--design", options.use.design),
                       named("--machine", options.machine.machine));
}

experiment::ChosenMachine machine_of(const nlohmann::ordered_json& run) {
  experiment::ChosenMachine chosen;
  chosen.config = explore::config_from(run.at("config"));
  return chosen;
}

/// Of all designs in results.json, where none is named.
int print_energies(const nlohmann::ordered_json& results, const CostArguments& options, bool as_json) {
  refuse_own_machine(options);
  const std::string machine = options.command->count("--machine") > 0 ? options.machine.machine : "";
  const nlohmann::ordered_json runs = energies_of(results, options.statistics, machine, options.cost, options.energy);
  if (!options.csv.empty()) write_file(options.csv, energies_csv(runs));
  if (as_json) {
    print_json({{"schema", "grtx.energy/1"}, {"runs", runs}});
  } else {
    fmt::print("{}", energies_text(runs));
  }
  return 0;
}

/// Throws Error for an option that another one leaves without meaning.
void refuse_meaningless(const CostArguments& options) {
  const auto refuse = [&](std::initializer_list<const char*> names, const char* rule) {
    for (const char* name : names) {
      if (options.command->count(name) > 0) throw Error("cost", name, rule);
    }
  };
  if (options.coefficients) {
    refuse({"--csv", "--stats", "--node", "--machine", "--config", "--set", "--design"},
           "means nothing beside --coefficients, which are of no machine");
  }
  if (options.statistics.empty()) {
    refuse({"--dram-pj-per-bit"}, "needs --stats: it is of a run's energy");
    return;
  }
  refuse({"--depth", "--items", "--checkpoint-entries", "--eviction-entries", "--checkpoint-copies"},
         "is of a machine's cost, but with --stats a run's energy is printed");
  refuse({"--pop-test", "--any-hit", "--sort-key", "--opacity-bound", "--objects", "--leaves", "--layout",
          "--bvh-width", "--checkpoint-bins", "--checkpoint-capacity"},
         "is what the run of --stats had");
}

int cost(CostArguments options, const CommonOptions& common) {
  const bool json = common.json;
  refuse_meaningless(options);
  if (options.coefficients) {
    if (json) throw Error("--json", "", "needs a machine: coefficients are Markdown");
    fmt::print("{}", explore::coefficient_reference());
    return 0;
  }
  explore::technology(options.cost.nm);  // throws for an unknown node before anything is built
  const bool of_a_run = !options.statistics.empty();
  sim::MachineUse use = options.use;
  use.peak = options.sort_key == frontend::SortKey::peak;
  nlohmann::ordered_json run;
  bool of_results = false;
  if (of_a_run) {  // whose design has units of its own only if --design names it
    run = read_json(options.statistics);
    of_results = is_results(run);
    if (of_results && options.command->count("--design") == 0) return print_energies(run, options, json);
    run = of_results ? one_of_results(run, options) : sim::read_statistics(options.statistics);
    use = explore::machine_of_run(run.at("inputs"), options.statistics);
    if (options.command->count("--design") > 0 && !of_results) take_design_of(run.at("inputs"), options);
  } else {
    options.machine.design = use.design;
  }
  const experiment::ChosenMachine chosen = of_results ? machine_of(run) : choose_machine(options.machine, common);
  const sim::GpuConfig& config = chosen.config;
  if (!of_a_run) {
    if (options.command->count("--leaves") == 0) use.leaves = sim::leaf_test_of(explore::design_of(use.design).accel);
    choose_for(options, chosen, use);
  }
  const std::vector<modules::Inventory> inventories = sim::machine_inventory(config, use);
  explore::MachineCost cost = explore::machine_cost(config, use.design, inventories, options.cost);
  cost.buffers.checkpoint_entries = options.buffers.checkpoint_entries;
  cost.buffers.eviction_entries = options.buffers.eviction_entries;
  cost.buffers.checkpoint_copies = options.buffers.checkpoint_copies;
  if (of_a_run) {
    print_energy(options, run, config, inventories, json);
    return 0;
  }
  if (!options.csv.empty()) write_file(options.csv, explore::cost_csv(cost));
  if (json) {
    print_json(explore::cost_json(cost));
  } else {
    fmt::print("{}", explore::cost_text(cost, options.depth, options.items));
  }
  return 0;
}

/// The structure that the machine traverses, which decides what units it has.
void add_structure_options(CLI::App* command, sim::MachineUse& use, frontend::SortKey& sort_key) {
  command
      ->add_option("--design", use.design,
                   "Which units the machine has, their own keys included; with --stats the design of the run")
      ->check(one_of(explore::design_names()));
  add_choice(command, "--pop-test", use.pop_test, "Whether stack entries hold their t; a machine may choose another");
  add_choice(command, "--any-hit", use.any_hit, "When any-hit shaders run; a machine may choose another");
  add_choice(command, "--sort-key", sort_key,
             "Distance of a hit that the ray-Gaussian unit finds; a machine may choose another");
  add_choice(command, "--opacity-bound", use.opacity_bound,
             "Whether heaps add up opacities; a machine may choose another");
  command->add_flag("--objects", use.objects, "Designs sw and grtx for scenes of several objects (default: off)");
  add_choice(command, "--leaves", use.leaves, "Kind of the primitive leaves; a shader tests boxes");
  add_choice(command, "--layout", use.layout, "Node image that the machine reads; a machine may choose another");
  command
      ->add_option(
          "--bvh-width", use.bvh_width,
          "Children of an internal node, 2 to 8; 0: as many as a line of the layout holds; a machine may choose "
          "another")
      ->check(in_range(0u, traces::kMaxWidth));
  command
      ->add_option("--checkpoint-bins", use.checkpoint_bins,
                   "Near checkpoint bins of a ray, 0 for two buffers; a machine may choose another number")
      ->check(in_range(0u, traces::kMaxCheckpointBins));
  command->add_option("--checkpoint-capacity", use.checkpoint_capacity, "Entries of a bin")
      ->check(in_range(1u, 65535u));
}

}  // namespace

void add_cost(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<CostArguments>();
  CLI::App* command = make_command(app, common, "cost", "Storage, area, timing and leakage by hierarchy",
                                   [options, &common] { return cost(*options, common); });
  options->command = command;
  add_machine_option(command, options->machine.machine);
  command
      ->add_option("--config", options->machine.config,
                   "Configuration file: what differs from the machine (default: none)")
      ->type_name(kInputFile);
  command->add_option("--set", options->machine.settings, "key=value, after the file; may be repeated (default: none)")
      ->allow_extra_args(false);
  add_structure_options(command, options->use, options->sort_key);
  command->add_option("--node", options->cost.nm, "Process node, nm: 45, 32, 28, 22, 16, 12, 7 or 5");
  command->add_option("--utilisation", options->cost.utilisation, "Share of the placed area that is cells")
      ->check(in_range(0.1, 1.0));
  command->add_option("--control", options->cost.control, "Factor on logic for control and interconnect")
      ->check(in_range(1.0, 10.0));
  command->add_option("--checkpoint-entries", options->buffers.checkpoint_entries,
                      "Entries of a ray's checkpoint buffer in global memory");
  command->add_option("--eviction-entries", options->buffers.eviction_entries, "Entries of a ray's eviction buffer");
  command
      ->add_option("--checkpoint-copies", options->buffers.checkpoint_copies,
                   "Checkpoint buffers per ray: source and destination")
      ->check(in_range(1u, 2u));
  command->add_option("--depth", options->depth, "Levels of the hierarchy that are printed");
  command->add_flag("--items", options->items, "Also list the parts of each module (default: off)");
  command
      ->add_option("--csv", options->csv,
                   "Every item, with --stats the energy by part, to this CSV file; in nJ (default: none)")
      ->type_name(kOutputFile);
  command
      ->add_option("--stats", options->statistics,
                   "Statistics of a run on this machine: prints the energy by part; or results.json of grtx run: of "
                   "all its designs and machines, or of --design (default: none)")
      ->type_name(kInputFile);
  command->add_option("--dram-pj-per-bit", options->energy.dram_pj_per_bit, "Energy of the DRAM: GDDR6 7.5, HBM2E 6")
      ->check(above_zero());
  command->add_flag("--coefficients", options->coefficients,
                    "Print every coefficient with source and confidence as Markdown (default: off)");
}

}  // namespace grtx::apps
