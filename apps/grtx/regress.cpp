// SPDX-License-Identifier: Apache-2.0
// grtx regress: runs a folder of traces with their machines and compares the statistics with those on record.
#include "grtx/rtl_tlm/regress/regression.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"
#include "grtx/experiment/machine.h"
#include "grtx/experiment/machine_notes.h"
#include "grtx/explore/cost/energy_statistics.h"
#include "grtx/explore/sweep/designs.h"
#include "grtx/explore/sweep/session.h"
#include "grtx/rtl_tlm/run/result_notes.h"
#include "grtx/traces/reader.h"

namespace grtx::apps {
namespace {

struct RegressArguments {
  sim::RegressionOptions regression;
  bool update = false;
};

// Values are text in the printed table; for JSON they are parsed.
nlohmann::ordered_json value_of(const std::string& json) {
  nlohmann::ordered_json value = nlohmann::ordered_json::parse(json, nullptr, false);
  return value.is_discarded() ? nullptr : value;
}

nlohmann::ordered_json regression_json(const std::vector<sim::RegressionOutcome>& outcomes) {
  nlohmann::ordered_json json = json_document("regress");
  json["cases"] = nlohmann::ordered_json::array();
  for (const sim::RegressionOutcome& outcome : outcomes) {
    nlohmann::ordered_json& c = json["cases"].emplace_back();
    c["case"] = outcome.regression_case.name;
    c["outcome"] = sim::outcome_name(outcome.kind);
    c["message"] = outcome.message;
    c["compared"] = outcome.comparison.compared;
    c["differences"] = nlohmann::ordered_json::array();
    for (const sim::StatisticDifference& difference : outcome.comparison.differences) {
      c["differences"].push_back({{"statistic", difference.name},
                                  {"unit", difference.unit.name},
                                  {"recorded", value_of(difference.recorded)},
                                  {"found", value_of(difference.found)},
                                  {"relative", difference.relative}});
    }
    c["unrecorded"] = outcome.comparison.unrecorded;
    c["seconds"] = outcome.seconds;
  }
  return json;
}

/// Files of a case's machine; none of one that is not valid, which the case says when it runs.
std::vector<std::string> machine_files(const sim::RegressionCase& c) {
  try {
    return experiment::choose_machine({.machine = c.machine, .config = c.config, .settings = c.settings}).files;
  } catch (const Error&) {
    return {};
  }
}

/// The keys of the design that a case names, at the k of its trace.
std::vector<std::string> design_keys(const sim::RegressionCase& c) {
  const std::vector<std::string>& names = explore::design_names();
  if (std::find(names.begin(), names.end(), c.design) == names.end()) {
    throw Error(c.file, "design",
                fmt::format("unknown '{}', the nearest is '{}'", c.design, nearest_name(c.design, names)));
  }
  const explore::Design& design = explore::design_of(c.design);
  const traces::Reader reader(c.trace);
  experiment::check_design(c.trace, reader.header(), design);
  std::vector<std::string> settings;
  for (const auto& [key, value] : explore::keys_for(design, reader.header().k)) settings.push_back(key + "=" + value);
  return settings;
}

/// Says, as `grtx sim` does, that a trace is of a design whose units the case lacks.
sim::SimulationResult simulate(const sim::RegressionCase& c, const sim::GpuConfig& config) {
  const traces::Reader reader(c.trace);
  sim::print_notes(
      {{"regress: " + c.name, experiment::design_notes(reader.header(), config, explore::keys_of(c.settings))}});
  return sim::simulate_case(c, config, explore::describe_energy);
}

int regress(RegressArguments options, const CommonOptions& common) {
  sim::RegressionOptions& regression = options.regression;
  if (options.update && regression.reason.empty()) throw Error("--update", "", "needs --reason TEXT");
  if (!options.update && !regression.reason.empty()) throw Error("--reason", "", "needs --update");
  regression.quiet = common.quiet;
  regression.silent = common.json;
  regression.program = explore::program_version();
  regression.machine = experiment::load_machine_config;
  regression.design_keys = design_keys;
  regression.simulate = simulate;
  for (const sim::RegressionCase& c : sim::load_regression(regression.folder)) {
    for (const std::string& file : {c.file, c.record, c.trace, c.config}) common.files.check(file);
    for (const std::string& file : machine_files(c)) common.files.check(file);
  }
  const std::vector<sim::RegressionOutcome> outcomes = sim::run_regression(regression);
  if (common.json) print_json(regression_json(outcomes));
  return sim::exit_code(outcomes);
}

}  // namespace

void add_regress(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<RegressArguments>();
  CLI::App* command =
      make_command(app, common, "regress", "Runs a folder of traces and compares their statistics with those on record",
                   [options, &common] { return regress(*options, common); });
  sim::RegressionOptions& regression = options->regression;
  command->add_option("DIR", regression.folder, "Folder with NAME.case.toml files, docs/guide/regress.md (no default)")
      ->required();
  command->add_option("--cases", regression.cases, "Shell pattern of the cases to run");
  command->add_option("--jobs", regression.jobs, "Cases at a time, each a process of its own")->check(above_zero());
  command->add_option("--each", regression.each,
                      "Print this many differing statistics of each unit, 0: all (default: those that moved most)");
  command->add_option("--junit", regression.junit, "Outcomes as JUnit XML (default: none)")->type_name(kOutputFile);
  command->add_flag("--update", options->update, "Record what differs or is new (default: off)");
  command->add_option("--reason", regression.reason, "With --update: why, for the case's file (default: none)");
}

}  // namespace grtx::apps
