// SPDX-License-Identifier: Apache-2.0
#include "grtx/apps/grtx/results_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <filesystem>

#include "grtx/base/error.h"
#include "grtx/rtl_tlm/run/statistics_json.h"

namespace grtx::apps {
namespace {

using nlohmann::ordered_json;

ordered_json member(const ordered_json& document, const std::string& name, const std::string& path) {
  const ordered_json found = document.value(name, ordered_json::object());
  if (!found.is_object()) throw Error(path, name, "must be an object");
  return found;
}

ordered_json list_of_machines(const ordered_json& results, const std::string& path) {
  ordered_json machines = results.value("machines", ordered_json::array({results}));
  if (!machines.is_array() || machines.empty()) throw Error(path, "machines", "must be a list of machines");
  for (const ordered_json& one : machines) {
    if (!one.is_object()) throw Error(path, "machines", "must be a list of objects");
  }
  return machines;
}

std::string recorded_name(const ordered_json& machine) {
  return machine.contains("machine") && machine.at("machine").is_string() ? machine.at("machine") : "";
}

/// Whether a machine of results.json is the one of --machine: its name, or the file that it is named after.
bool is_asked(const std::string& name, const std::string& asked) {
  const std::string own = name.substr(0, name.find(','));
  return name == asked || own == asked || own == std::filesystem::path(asked).stem().string();
}

/// The members of a machine: those of the document, or of one of its `machines`.
ordered_json machine_of(const ordered_json& results, const std::string& path, const std::string& machine) {
  const ordered_json machines = list_of_machines(results, path);
  std::vector<std::string> names;
  for (const ordered_json& one : machines) {
    const std::string name = recorded_name(one);
    if (machine.empty() ? machines.size() == 1 : is_asked(name, machine)) return one;
    names.push_back(name.substr(0, name.find(',')));
  }
  throw Error(path, "machines", fmt::format("--machine must name one of {}", fmt::join(names, ", ")));
}

}  // namespace

bool is_results(const ordered_json& document) {
  if (!document.is_object()) return false;
  const ordered_json schema = document.value("schema", ordered_json());
  return schema == "grtx.run/2" || schema == "grtx.run/1";
}

std::vector<std::pair<std::string, std::vector<std::string>>> runs_of(const ordered_json& results,
                                                                      const std::string& path,
                                                                      const std::string& machine) {
  std::vector<std::pair<std::string, std::vector<std::string>>> runs;
  const ordered_json all =
      machine.empty() ? list_of_machines(results, path) : ordered_json::array({machine_of(results, path, machine)});
  for (const ordered_json& one : all) {
    auto& [name, designs] = runs.emplace_back(recorded_name(one), std::vector<std::string>());
    const ordered_json ran = member(one, "designs", path);
    for (const auto& [design, statistics] : ran.items()) designs.push_back(design);
  }
  return runs;
}

ordered_json statistics_of(const ordered_json& results, const std::string& path, const std::string& design,
                           const std::string& machine) {
  const ordered_json of = machine_of(results, path, machine), designs = member(of, "designs", path);
  std::vector<std::string> names;
  for (const auto& [name, statistics] : designs.items()) names.push_back(name);
  if (!designs.contains(design)) {
    throw Error(path, "designs", fmt::format("--design must name one of {}", fmt::join(names, ", ")));
  }
  sim::check_statistics(designs.at(design), path, design + ": ");
  ordered_json config = member(of, "config", path);
  config.update(member(member(of, "design_config", path), design, path));
  return {{"schema", "grtx.stats/1"},
          {"config", std::move(config)},
          {"inputs", member(member(of, "inputs", path), design, path)},
          {"stats", designs.at(design)}};
}

double statistic_value(const ordered_json& statistics, const std::string& name) {
  const auto found = statistics.find(name);
  const bool counted = found != statistics.end() && found->at("value").is_number();
  return counted ? found->at("value").get<double>() : std::nan("");
}

std::string shown_value(double value, int decimals, const char* unit) {
  return std::isfinite(value) ? fmt::format("{:.{}f}{}", value, decimals, unit) : "-";
}

}  // namespace grtx::apps
