// SPDX-License-Identifier: Apache-2.0
// grtx stalls: where the cycles of a run went.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/apps/grtx/results_file.h"
#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/rtl_tlm/observe/stall_report.h"
#include "grtx/rtl_tlm/run/statistics_json.h"

namespace grtx::apps {
namespace {

struct StallsArguments {
  std::string statistics;
  std::string design, machine;
  unsigned columns = 38;  ///< lines of 80 columns
};

std::string stall_json(const std::vector<sim::StallSection>& sections) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const sim::StallSection& section : sections) {
    nlohmann::ordered_json& entry = list.emplace_back();
    entry = {{"title", section.title}, {"unit", section.unit}, {"whole", section.whole}};
    for (const sim::StallBar& bar : section.bars) entry["bars"][bar.label] = bar.value;
  }
  return json_text(list, 1) + "\n";
}

/// The statistics of a design in a document of `grtx run`; any other document as it is. Throws Error.
nlohmann::ordered_json statistics_in(nlohmann::ordered_json document, const StallsArguments& options) {
  if (is_results(document)) return statistics_of(document, options.statistics, options.design, options.machine);
  for (const auto& [option, text] : {std::pair("--design", options.design), std::pair("--machine", options.machine)}) {
    if (!text.empty()) throw Error("stalls", option, "is for results.json of grtx run");
  }
  return document;
}

int print_stalls(const StallsArguments& options, bool json) {
  const nlohmann::ordered_json document = statistics_in(read_json(options.statistics), options);
  if (document.is_object() && document.contains("stats")) {
    sim::check_statistics(document.at("stats"), options.statistics, "");
  }
  const std::vector<sim::StallSection> sections = sim::stall_sections(document, options.statistics);
  fmt::print("{}", json ? stall_json(sections) : sim::stall_text(sections, options.columns));
  return 0;
}

}  // namespace

void add_stalls(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<StallsArguments>();
  CLI::App* command = make_command(app, common, "stalls", "Shows where the cycles of a simulation went, as text bars",
                                   [options, &common] { return print_stalls(*options, common.json); });
  command->add_option("STATS", options->statistics, "Statistics JSON of grtx sim --stats, or results.json of grtx run")
      ->type_name(kInputFile)
      ->required();
  command->add_option("--design", options->design, "Design of results.json whose cycles are shown (default: none)");
  command->add_option("--machine", options->machine, "Machine of results.json, where it has several (default: none)");
  command->add_option("--columns", options->columns, "Characters of a full bar")->check(in_range(1, 500));
}

}  // namespace grtx::apps
