// SPDX-License-Identifier: Apache-2.0
#include "grtx/apps/grtx/results_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

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

/// The members of a machine: those of the document, or of one of its `machines`.
ordered_json machine_of(const ordered_json& results, const std::string& path, const std::string& machine) {
  const ordered_json machines = results.value("machines", ordered_json::array({results}));
  if (!machines.is_array() || machines.empty()) throw Error(path, "machines", "must be a list of machines");
  std::vector<std::string> names;
  for (const ordered_json& one : machines) {
    if (!one.is_object()) throw Error(path, "machines", "must be a list of objects");
    const std::string name = one.contains("machine") && one.at("machine").is_string() ? one.at("machine") : "";
    if (machine.empty() ? machines.size() == 1 : name == machine || name.substr(0, name.find(',')) == machine) {
      return one;
    }
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

}  // namespace grtx::apps
