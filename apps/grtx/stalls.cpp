// SPDX-License-Identifier: Apache-2.0
// grtx stalls: where the cycles of a run went.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <string>
#include <vector>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/rtl_tlm/observe/stall_report.h"
#include "grtx/rtl_tlm/run/statistics_json.h"

namespace grtx::apps {
namespace {

struct StallsArguments {
  std::string statistics;
  std::string design;
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
nlohmann::ordered_json statistics_of(nlohmann::ordered_json document, const StallsArguments& options) {
  const bool of_run = document.is_object() && document.value("schema", nlohmann::ordered_json()) == "grtx.run/1";
  if (!of_run) {
    if (!options.design.empty()) throw Error("stalls", "--design", "is for results.json of grtx run");
    return document;
  }
  const nlohmann::ordered_json designs = document.value("designs", nlohmann::ordered_json::object());
  std::vector<std::string> names;
  for (const auto& [name, statistics] : designs.items()) names.push_back(name);
  if (!designs.contains(options.design)) {
    throw Error(options.statistics, "designs", fmt::format("--design must name one of {}", fmt::join(names, ", ")));
  }
  return {{"schema", "grtx.stats/1"},
          {"config", document.value("config", nlohmann::ordered_json::object())},
          {"stats", designs.at(options.design)}};
}

int print_stalls(const StallsArguments& options, bool json) {
  const nlohmann::ordered_json document = statistics_of(read_json(options.statistics), options);
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
  command->add_option("--columns", options->columns, "Characters of a full bar")->check(in_range(1, 500));
}

}  // namespace grtx::apps
