// SPDX-License-Identifier: Apache-2.0
// grtx report: tables and charts of sweeps and runs in one HTML file.
#include "grtx/report/page/report.h"

#include <memory>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/base/atomic_file.h"

namespace grtx::apps {
namespace {

struct ReportArguments {
  report::ReportOptions report;
  std::string output;
};

}  // namespace

void add_report(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<ReportArguments>();
  CLI::App* command =
      make_command(app, common, "report", "Charts and tables of sweeps and runs in one HTML file", [options, &common] {
        write_file(options->output, report::report_page(options->report));
        if (common.json) {
          nlohmann::ordered_json json = json_document("report");
          json["report"] = options->output;
          json["title"] = options->report.title;
          json["inputs"] = options->report.inputs;
          json["images"] = options->report.images;
          print_json(json);
        }
        return 0;
      });
  command
      ->add_option("INPUT", options->report.inputs,
                   "Sweep databases, results.json of grtx run, statistics of grtx sim (no default)")
      ->type_name(kInputFile)
      ->required();
  command->add_option("-o,--output", options->output, "HTML file to write (no default)")
      ->type_name(kOutputFile)
      ->required();
  command
      ->add_option("--image", options->report.images,
                   "Picture to show, e.g. a heat map; PNG, JPEG, GIF or WebP; may be repeated (default: none)")
      ->type_name(kInputFile)
      ->allow_extra_args(false);
  command->add_option("--title", options->report.title, "Title of the page");
}

}  // namespace grtx::apps
