// grtx stalls: where the cycles of a run went.
#include <fmt/format.h>

#include <memory>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/rtl_tlm/observe/stall_report.h"
#include "grtx/rtl_tlm/run/json_file.h"
#include "grtx/rtl_tlm/run/statistics_json.h"

namespace grtx::sim {
namespace {

struct Options {
  std::string statistics;
  unsigned columns = 50;
};

int print_stalls(const Options& options) {
  const nlohmann::ordered_json document = read_json(options.statistics);
  if (document.is_object() && document.contains("stats")) {
    check_statistics(document.at("stats"), options.statistics, "");
  }
  fmt::print("{}", stall_text(stall_sections(document, options.statistics), options.columns));
  return 0;
}

}  // namespace

void add_stalls(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = make_command(app, common, "stalls", "Shows where the cycles of a simulation went, as text bars",
                                   [options] { return print_stalls(*options); });
  command->add_option("STATS", options->statistics, "Statistics JSON of grtx sim --stats")
      ->type_name(kInputFile)
      ->required();
  command->add_option("--columns", options->columns, "Characters of a full bar")->check(CLI::Range(1, 500));
}

}  // namespace grtx::sim
