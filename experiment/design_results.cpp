// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/design_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/experiment/machine_notes.h"
#include "grtx/report/page/speedup_terms.h"
#include "grtx/rtl_tlm/estimate/estimate.h"
#include "grtx/rtl_tlm/run/model_version.h"
#include "grtx/traces/reader.h"

namespace grtx::experiment {
namespace {

using nlohmann::ordered_json;

double statistic(const ordered_json& statistics, const std::string& name) {
  return statistics.at(name).at("value").get<double>();
}

/// Separate speed-ups of primary and of secondary rays, as in the paper's figure on secondary rays.
void add_speedups_by_kind(ordered_json& results, const DesignComparison& comparison) {
  for (const char* kind : {"primary", "secondary"}) {
    const std::string cycles = fmt::format("gpu.rays.{}_cycles", kind);
    const double reference = statistic(results["designs"][comparison.reference()], cycles);
    for (const std::string& name : comparison.others()) {
      const double own = statistic(results["designs"][name], cycles);
      if (own > 0.0) results[fmt::format("speedup_{}", kind)][name] = reference / own;
    }
  }
}

/// What each term of a design contributes to its speed-up.
void add_waterfall(ordered_json& results, const DesignComparison& comparison) {
  const auto values_of = [&](const std::string& design) {
    return [&own = results["designs"][design]](const std::string& name) {
      const auto found = own.find(name);
      return found == own.end() ? std::nan("") : found->at("value").get<double>();
    };
  };
  for (const std::string& name : comparison.others()) {
    for (const report::SpeedupTerm& term : report::speedup_terms(values_of(comparison.reference()), values_of(name))) {
      results["waterfall"][name].push_back({{"term", term.name},
                                            {"from", term.from},
                                            {"to", term.to},
                                            {"cycles", term.cycles},
                                            {"speedup", term.factor}});
    }
  }
}

/// Cycles and speed-ups per frame of a sequence.
void add_frames(ordered_json& results, const DesignComparison& comparison, const std::string& views,
                std::size_t frames) {
  ordered_json& list = results["frames"];
  list["views"] = views;
  for (std::size_t i = 0; i < frames; ++i) {
    const std::string cycles = fmt::format("gpu.frame{}.cycles", i);
    const double reference = statistic(results["designs"][comparison.reference()], cycles);
    for (const std::string& name : comparison.names()) {
      const double own = statistic(results["designs"][name], cycles);
      list["cycles"][name].push_back(own);
      if (name != comparison.reference()) list["speedup"][name].push_back(reference / own);
    }
  }
}

/// Confidence intervals of cycles and speed-ups. Speed-ups are paired: all designs simulate the same windows.
void add_intervals(const std::map<std::string, ordered_json>& documents, const DesignComparison& comparison,
                   ordered_json& results) {
  const auto json = [](const sim::ConfidenceInterval& interval) {
    return ordered_json{{"low", interval.low}, {"high", interval.high}, {"confidence", sim::kConfidence}};
  };
  const sim::CycleEstimate reference = sim::estimate_from_json(documents.at(comparison.reference()).at("windows"));
  for (const std::string& name : comparison.names()) {
    const sim::CycleEstimate estimate = sim::estimate_from_json(documents.at(name).at("windows"));
    results["cycles_interval"][name] = json(sim::cycles_interval(estimate));
    if (name != comparison.reference())
      results["speedup_interval"][name] = json(sim::ratio_interval(reference, estimate));
  }
}

/// One design: its statistics, notes, inputs, bound and violations. whose: how it is called in messages.
void add_design(DesignResults& run, ordered_json& results, const std::string& name, const std::string& whose,
                const MachinePlan& plan, const TracedDesigns& traced, ordered_json& document) {
  const TracedDesign& own = traced.designs.at(name);
  ordered_json& design = results["designs"][name];
  design = own.statistics;
  design.update(document.at("stats"));
  // The user may have overridden tracer options of the machine.
  const std::map<std::string, std::string> chosen =
      plan.chosen_tracer ? *plan.chosen_tracer : machine_tracer(plan.machine);
  put_first(tracer_notes(plan.machine, chosen, &explore::design_of(name), traces::Reader(own.path).header()), document);
  results["notes"][name] = document.at("notes");
  run.notes[whose] = sim::notes_from(results["notes"][name], name);
  const ordered_json& inputs = results["inputs"][name] = document.at("inputs");
  if (inputs.value(std::string("trace.") + kFilesHash, "") != traced.files_hash) {
    throw Error(own.path, "", "was replaced by another trace while the run was under way");
  }
  results["binding_bound"][name] = document.at("binding_bound");
  if (document.contains("over_time")) results["over_time"][name] = document.at("over_time");  // not of windows
  for (const auto& violation : document.at("violations")) {
    run.violations.push_back(fmt::format("{}: {}", whose, violation.get<std::string>()));
  }
}

/// The members of results.json that belong to a machine.
ordered_json machine_results(DesignResults& run, const RunPlan& plan, const MachinePlan& machine,
                             const TracedDesigns& traced, std::map<std::string, ordered_json>& documents) {
  const DesignComparison& comparison = run.comparison;
  ordered_json results;
  results["machine"] = machine_name(machine.machine, machine.config, machine.machine_hash);
  results["config"] = sim::config_json(machine.config);
  // Without this entry, readers take the baseline.
  if (comparison.reference() != explore::design_names().front()) results["speedup_over"] = comparison.reference();
  for (const ComparedDesign& design : comparison.designs()) {
    const unsigned k = design_settings(machine.tracer, design, plan.named).options.k;
    for (const auto& [key, value] : explore::keys_for(design, k)) {
      if (!plan.named.contains(key)) results["design_config"][design.name][key] = value;
    }
  }
  for (const std::string& name : comparison.names()) {
    const std::string whose = name + (plan.further.empty() ? "" : " on " + machine_name(machine.machine));
    add_design(run, results, name, whose, machine, traced, documents.at(name));
  }
  const double reference = statistic(results["designs"][comparison.reference()], "gpu.cycles");
  for (const std::string& name : comparison.others()) {
    results["speedup"][name] = reference / statistic(results["designs"][name], "gpu.cycles");
  }
  add_waterfall(results, comparison);
  if (run.mode != sim::SimulationMode::cycle) add_intervals(documents, comparison, results);
  if (run.mode != sim::SimulationMode::windows && plan.tracer.secondary.what != "none") {
    add_speedups_by_kind(results, comparison);
  }
  return results;
}

/// Each design's time on the first machine over that on another, and keys and options in which machines differ.
ordered_json between_machines(const std::vector<MachinePlan>& machines, const ordered_json& results) {
  ordered_json between;
  const ordered_json& first = results.front();
  between["over"] = first.at("machine");
  for (const ordered_json& other : results) {
    if (&other == &first) continue;
    const auto machine = other.at("machine").get<std::string>();
    for (const auto& [name, statistics] : other.at("designs").items()) {
      const ordered_json& its = first.at("designs").at(name);
      const double ratio = statistic(its, "gpu.time_us") / statistic(statistics, "gpu.time_us");
      between["speedup"][machine][name] = ratio;
      if (!other.contains("cycles_interval")) continue;
      // Of estimates; conservative, as windows of two machines are no pairs.
      const ordered_json &over = first.at("cycles_interval").at(name), &of = other.at("cycles_interval").at(name);
      const double scale = ratio * statistic(statistics, "gpu.cycles") / statistic(its, "gpu.cycles");
      between["speedup_interval"][machine][name] = {
          {"low", scale * over.at("low").get<double>() / of.at("high").get<double>()},
          {"high", scale * over.at("high").get<double>() / of.at("low").get<double>()},
          {"confidence", sim::kConfidence}};
    }
  }
  between["keys"] = ordered_json::object();
  const auto add = [&](const std::string& key, const std::vector<ordered_json>& values) {
    if (std::ranges::any_of(values, [&](const ordered_json& value) { return value != values.front(); })) {
      between["keys"][key] = values;
    }
  };
  for (const auto& [key, value] : first.at("config").items()) {
    std::vector<ordered_json> values;
    for (const ordered_json& machine : results) values.push_back(machine.at("config").at(key));
    add(key, values);
  }
  for (const auto& [option, text] : option_texts(machines.front().tracer)) {
    std::vector<ordered_json> values;
    for (const MachinePlan& machine : machines) values.emplace_back(option_texts(machine.tracer).at(option));
    add("tracer." + option, values);
  }
  return between;
}

}  // namespace

DesignResults design_results(const RunPlan& plan, const DesignComparison& comparison,
                             const std::vector<TracedDesigns>& traced,
                             std::vector<std::map<std::string, ordered_json>> documents, const ordered_json& images) {
  DesignResults run(comparison);
  run.mode = plan.mode.value();
  run.counters = traced.front().counters;
  run.images_identical = traced.front().identical;
  ordered_json& results = run.json;
  results["schema"] = "grtx.run/2";
  results["version"] = GRTX_VERSION;
  results["model_version"] = sim::kModelVersion;
  const std::vector<MachinePlan> machines = machines_of(plan);
  ordered_json of_machines = ordered_json::array();
  for (std::size_t m = 0; m < machines.size(); ++m) {
    of_machines.push_back(machine_results(run, plan, machines[m], traced[m], documents[m]));
  }
  const bool sequence = traced.front().images.size() > 1;
  if (machines.size() == 1) {
    for (auto& [name, value] : of_machines.front().items()) results[name] = std::move(value);
  } else {
    for (ordered_json& machine : of_machines) {
      if (sequence) add_frames(machine, comparison, plan.view.views, traced.front().images.size());
    }
    results["between_machines"] = between_machines(machines, of_machines);
    results["machines"] = std::move(of_machines);
  }
  results["images"] = images;
  if (!comparison.left_out().empty()) results["left_out"] = comparison.left_out();
  if (sequence && machines.size() == 1) add_frames(results, comparison, plan.view.views, traced.front().images.size());
  results["images_identical"] = traced.front().identical;
  for (const auto& [name, order] : traced.front().other_orders) {
    results["other_orders"][name] = {{"order", order.order}, {"psnr", order.psnr}};
  }
  for (const std::string& name : comparison.names()) {
    results["pictures"][name] = picture_json(traced.front().pictures.at(name));
  }
  results["violations"] = run.violations;
  return run;
}

}  // namespace grtx::experiment
