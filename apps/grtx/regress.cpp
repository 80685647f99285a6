// grtx regress: runs a folder of traces with their machines and compares the statistics with those on record.
#include "grtx/rtl_tlm/regress/regression.h"

#include <memory>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/machine.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/base/error.h"
#include "grtx/explore/cost/energy_statistics.h"
#include "grtx/explore/sweep/session.h"

namespace grtx::sim {
namespace {

struct Options {
  RegressionOptions regression;
  bool update = false;
};

int regress(Options options, bool quiet) {
  RegressionOptions& regression = options.regression;
  if (options.update && regression.reason.empty()) throw Error("--update", "", "needs --reason TEXT");
  if (!options.update && !regression.reason.empty()) throw Error("--reason", "", "needs --update");
  regression.quiet = quiet;
  regression.program = program_version();
  regression.machine = load_machine_config;
  regression.price = describe_energy;
  return exit_code(run_regression(regression));
}

}  // namespace

void add_regress(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<Options>();
  CLI::App* command =
      make_command(app, common, "regress", "Runs a folder of traces and compares their statistics with those on record",
                   [options, &common] { return regress(*options, common.quiet); });
  RegressionOptions& regression = options->regression;
  command->add_option("DIR", regression.folder, "Folder with NAME.case.toml files, docs/guide/regress.md (no default)")
      ->required();
  command->add_option("--cases", regression.cases, "Shell pattern of the cases to run");
  command->add_option("--jobs", regression.jobs, "Cases at a time, each a process of its own")
      ->check(CLI::PositiveNumber);
  command->add_option("--each", regression.each, "Differing statistics of a unit that are printed; 0: all");
  command->add_option("--junit", regression.junit, "Outcomes as JUnit XML (default: none)")->type_name(kOutputFile);
  command->add_flag("--update", options->update, "Record what differs or is new (default: off)");
  command->add_option("--reason", regression.reason, "With --update: why, for the case's file (default: none)");
}

}  // namespace grtx::sim
