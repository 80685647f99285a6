// SPDX-License-Identifier: Apache-2.0
// grtx correlate: compares measured values of real machines with a sweep.
#include "grtx/report/page/correlate.h"

#include <fmt/format.h>

#include <filesystem>
#include <limits>
#include <memory>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/base/atomic_file.h"

namespace grtx::apps {
namespace {

struct CorrelateArguments {
  std::string measured, database, card, output;
  double within = std::numeric_limits<double>::infinity();
};

int correlate_files(const CorrelateArguments& options, const CommonOptions& common) {
  const report::SweepResults sweep = report::read_sweep_results(options.database);
  const report::Correlation result =
      report::correlate(report::of_card(report::read_measured(options.measured), options.card, options.measured), sweep,
                        options.database);
  if (!options.output.empty()) {
    const std::string name = std::filesystem::path(options.measured).filename().string();
    write_file(options.output, report::correlation_page(result, name, sweep));
  }
  if (common.json) {
    nlohmann::ordered_json document = json_document("correlate");
    document.update(report::correlation_json(result));
    print_json(document);
  } else if (options.output.empty() || !common.quiet) {
    fmt::print("{}", report::correlation_text(result));
  }
  return result.mean_error > options.within ? 1 : 0;
}

}  // namespace

void add_correlate(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<CorrelateArguments>();
  CLI::App* command =
      make_command(app, common, "correlate", "Measured figures of real machines against a sweep: errors and ranks",
                   [options, &common] { return correlate_files(*options, common); });
  command->add_option("MEASURED", options->measured, "CSV of measured figures (no default)")
      ->type_name(kInputFile)
      ->required();
  command->add_option("DATABASE", options->database, "Database of grtx sweep (no default)")
      ->type_name(kInputFile)
      ->required();
  command
      ->add_option("--card", options->card,
                   "Card whose figures are compared, as MEASURED names it (default: its only one)")
      ->type_name("TEXT");
  command->add_option("-o,--output", options->output, "HTML page with a scatter to write (default: none)")
      ->type_name(kOutputFile);
  command->add_option("--within", options->within, "Largest mean error, 0.1 for 10 %; exit 1 above it (default: any)")
      ->check(in_range(0.0, 1e6));
}

}  // namespace grtx::apps
