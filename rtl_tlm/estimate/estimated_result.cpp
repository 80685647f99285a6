// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/estimate/estimated_result.h"

#include <cmath>
#include <utility>

#include "grtx/base/child_process.h"
#include "grtx/base/json.h"
#include "grtx/rtl_tlm/run/statistics_json.h"

namespace grtx::sim {

using nlohmann::ordered_json;

void describe_interval(const EstimatedResult& r, modules::StatisticList& list) {
  const auto add = [&list](const char* name, double value, const char* unit, const char* description) {
    list.add(std::string("gpu.windows.") + name, value, unit, description, modules::StatisticKind::state);
  };
  add("confidence", kConfidence, "ratio", "probability with which the interval is meant to hold the true value");
  add("cycles_low", r.cycles.low, "cycles", "lower end of the interval on gpu.cycles");
  add("cycles_high", r.cycles.high, "cycles", "upper end of the interval on gpu.cycles");
  add("half_width", r.cycles.half_width, "ratio", "relative half-width of the interval on gpu.cycles");
  add("deviation", r.cycles.deviation, "ratio", "standard deviation of the logarithm of gpu.cycles, all terms");
  add("drift", r.estimate.drift, "ratio",
      "of it: what the first halves of the windows took more than the second, over gpu.cycles");
}

void make_whole(EstimatedResult& r) {
  r.estimate = {};
  r.estimate.log_cycles = std::log(static_cast<double>(r.result.cycles));
  r.estimate.whole = true;
  r.cycles = cycles_interval(r.estimate);
  r.cycles.value = r.cycles.low = r.cycles.high = static_cast<double>(r.result.cycles);  // exp(log(x)) rounds
}

void add_to_document(const modules::StatisticList& statistics, EstimatedResult& r) {
  const ordered_json own = statistics_object(statistics);
  ordered_json& stats = r.result.document.at("stats");
  ordered_json all = ordered_json::object();
  bool added = false;
  for (const auto& [name, entry] : stats.items()) {
    if (name.starts_with("host.") && !std::exchange(added, true)) all.update(own);
    all[name] = entry;
  }
  if (!added) all.update(own);
  stats = std::move(all);
  for (const auto& [name, value] : r.result.inputs) r.result.document.at("inputs")[name] = value;
  r.result.document["windows"] = to_json(r.estimate);
}

SimulationResult simulate_in_child(const std::string& trace_path, const GpuConfig& config,
                                   const SimulationOptions& options) {
  ChildProcess child("simulation", [&] {
    const SimulationResult result = simulate(trace_path, config, options);
    ordered_json json;
    json["document"] = result.document;
    json["violations"] = result.violations;
    json["binding_bound"] = result.binding_bound;
    return json_text(json);
  });
  const ordered_json json = parse_json(child.result(), "simulation");
  SimulationResult result;
  result.document = json.at("document");
  result.violations = json.at("violations").get<std::vector<std::string>>();
  result.notes = notes_from(result.document.at("notes"), trace_path);
  result.inputs = result.document.at("inputs").get<std::map<std::string, std::string>>();
  result.binding_bound = json.at("binding_bound").get<std::string>();
  result.cycles = result.document.at("stats").at("gpu.cycles").at("value").get<Cycle>();
  return result;
}

}  // namespace grtx::sim
