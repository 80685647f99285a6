// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/design_results.h"

#include <fmt/format.h>

#include <utility>

#include "grtx/base/error.h"
#include "grtx/experiment/machine_notes.h"
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

/// One design: its statistics, notes, inputs, bound and violations.
void add_design(DesignResults& run, const std::string& name, const RunPlan& plan, const TracedDesigns& traced,
                ordered_json& document) {
  ordered_json& results = run.json;
  const TracedDesign& own = traced.designs.at(name);
  ordered_json& design = results["designs"][name];
  design = own.statistics;
  design.update(document.at("stats"));
  // The user may have overridden tracer options of the machine.
  const std::map<std::string, std::string> chosen =
      plan.chosen_tracer ? *plan.chosen_tracer : machine_tracer(plan.machine);
  put_first(tracer_notes(plan.machine, chosen, &explore::design_of(name), traces::Reader(own.path).header()), document);
  results["notes"][name] = document.at("notes");
  run.notes[name] = sim::notes_from(results["notes"][name], name);
  const ordered_json& inputs = results["inputs"][name] = document.at("inputs");
  if (inputs.value(std::string("trace.") + kFilesHash, "") != traced.files_hash) {
    throw Error(own.path, "", "was replaced by another trace while the run was under way");
  }
  results["binding_bound"][name] = document.at("binding_bound");
  for (const auto& violation : document.at("violations")) {
    run.violations.push_back(fmt::format("{}: {}", name, violation.get<std::string>()));
  }
}

}  // namespace

DesignResults design_results(const RunPlan& plan, const DesignComparison& comparison, const TracedDesigns& traced,
                             std::map<std::string, ordered_json> documents, const ordered_json& images) {
  DesignResults run(comparison);
  run.mode = plan.mode.value();
  run.counters = traced.counters;
  run.images_identical = traced.identical;
  ordered_json& results = run.json;
  results["schema"] = "grtx.run/1";
  results["version"] = GRTX_VERSION;
  results["model_version"] = sim::kModelVersion;
  results["machine"] = machine_name(plan.machine, plan.config, plan.machine_hash);
  results["config"] = sim::config_json(plan.config);
  // Without this entry, readers take the baseline.
  if (comparison.reference() != explore::design_names().front()) results["speedup_over"] = comparison.reference();
  for (const ComparedDesign& design : comparison.designs()) {
    const unsigned k = design_settings(plan.tracer, design, plan.named).options.k;
    for (const auto& [key, value] : explore::keys_for(design, k)) {
      if (!plan.named.contains(key)) results["design_config"][design.name][key] = value;
    }
  }
  for (const std::string& name : comparison.names()) add_design(run, name, plan, traced, documents.at(name));
  const double reference = statistic(results["designs"][comparison.reference()], "gpu.cycles");
  for (const std::string& name : comparison.others()) {
    results["speedup"][name] = reference / statistic(results["designs"][name], "gpu.cycles");
  }
  if (run.mode != sim::SimulationMode::cycle) add_intervals(documents, comparison, results);
  if (run.mode != sim::SimulationMode::windows && plan.tracer.secondary.what != "none") {
    add_speedups_by_kind(results, comparison);
  }
  results["images"] = images;
  if (traced.images.size() > 1) add_frames(results, comparison, plan.view.views, traced.images.size());
  results["images_identical"] = traced.identical;
  for (const auto& [name, order] : traced.other_orders) {
    results["other_orders"][name] = {{"order", order.order}, {"psnr", order.psnr}};
  }
  for (const std::string& name : comparison.names()) {
    results["pictures"][name] = picture_json(traced.pictures.at(name));
  }
  results["violations"] = run.violations;
  return run;
}

}  // namespace grtx::experiment
