// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/search/stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "grtx/base/error.h"
#include "grtx/base/geometric_mean.h"
#include "grtx/base/nearest_name.h"
#include "grtx/rtl_tlm/estimate/windows/window_refusal.h"

namespace grtx::explore {
namespace {

bool is_cost(const std::string& name) { return name.starts_with("cost."); }

/// Rounded, since the last bit of logarithms differs between mathematical libraries and must not decide who is on a
/// front.
double geometric_mean_of_ratios(const std::vector<double>& values, const std::vector<double>& reference) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < values.size(); ++i) ratios.push_back(values[i] / reference[i]);
  return nine_digits(geometric_mean(ratios));
}

void keep_scenes(SweepPlan& plan, bool evaluation) {
  std::erase_if(plan.scenes, [&](const PlanScene& scene) { return scene.evaluation != evaluation; });
}

unsigned scaled(unsigned pixels, double scale) {
  return static_cast<unsigned>(std::max(1L, std::lround(pixels * scale)));
}

}  // namespace

SweepPlan screening_plan(const SearchPlan& search) {
  SweepPlan plan = search.common;
  plan.settings.insert(plan.settings.end(), search.screening.begin(), search.screening.end());
  keep_scenes(plan, false);
  if (search.screening_scale == 1.0) return plan;
  for (PlanScene& scene : plan.scenes) {
    scene.width = scaled(scene.width, search.screening_scale);
    scene.height = scaled(scene.height, search.screening_scale);
    scene.name += fmt::format("-{}x{}", scene.width, scene.height);  // told apart from the whole image's points
  }
  return plan;
}

SweepPlan confirming_plan(const SearchPlan& search) {
  SweepPlan plan = search.common;
  plan.mode = search.confirm;
  keep_scenes(plan, false);
  return plan;
}

SweepPlan evaluation_plan(const SearchPlan& search) {
  SweepPlan plan = search.common;
  plan.mode = search.confirm;
  keep_scenes(plan, true);
  return plan;
}

Stage::Stage(SweepPlan plan, const SearchPlan& search, const TracerRules& tracer, SweepSession& session, Prices& prices)
    : plan_(std::move(plan)),
      search_(search),
      session_(session),
      prices_(prices),
      maker_(plan_, tracer, program_version()),
      reference_(make(search.reference)) {
  assert(!reference_.empty());  // every stage has a scene
  if (const Verdict verdict = check_costs(reference_); verdict.kind == Verdict::Kind::broken) {
    throw Error(plan_.path, search_.reference_place, "reference: " + verdict.reason);
  }
  std::vector<std::string> costs;
  for (const auto& [name, value] : prices_.costs(reference_.front().point)) costs.push_back(name);
  for (const SearchObjective& objective : search_.objectives) {
    if (is_cost(objective.value)) check_name(objective.value, objective.place, costs);
  }
  for (const SearchConstraint& constraint : search_.constraints) {
    if (is_cost(constraint.value)) check_name(constraint.value, constraint.place, costs);
  }
}

Stage::DesignPoints Stage::make(const Coordinates& design) {
  DesignPoints made;
  const std::string default_design = plan_.designs.empty() ? "" : plan_.designs.front();
  for (const PointMaker::Place& place : maker_.places()) made.push_back(maker_.make(place, default_design, design));
  return made;
}

void Stage::check_name(const std::string& name, const std::string& place, const std::vector<std::string>& known) const {
  if (std::find(known.begin(), known.end(), name) != known.end()) return;
  throw Error(plan_.path, place,
              fmt::format("unknown value '{}', the nearest is '{}'", name, nearest_name(name, known)));
}

Verdict Stage::check_costs(const DesignPoints& design) {
  Verdict verdict;
  const SweepPoint& first = design.front().point;
  for (const PointMaker::TracedPoint& made : design) {
    if (verdict.reason.empty()) verdict.reason = made.point.broken;
  }
  if (verdict.reason.empty()) {
    if (const auto mode = from_name<sim::SimulationMode>(plan_.mode)) {
      if (const sim::Unmodelled key = sim::unmodelled(config_from(first.config.json()), *mode)) {
        verdict.reason = fmt::format("{}: {}", key.key, key.rule);
      }
    }
  }
  if (!verdict.reason.empty()) {
    verdict.kind = Verdict::Kind::broken;
    return verdict;
  }
  for (const SearchConstraint& constraint : search_.constraints) {
    if (!is_cost(constraint.value)) continue;
    const auto price = [&](const DesignPoints& priced) {
      const auto& prices = prices_.costs(priced.front().point);
      const auto found = prices.find(constraint.value);
      return std::vector<double>{found == prices.end() ? 0.0 : found->second};
    };
    apply(constraint, price(design), price(reference_), verdict);
  }
  return verdict;
}

void Stage::apply(const SearchConstraint& constraint, const std::vector<double>& values,
                  const std::vector<double>& reference, Verdict& verdict) const {
  double value = 0.0;
  if (constraint.relative) {
    value = geometric_mean_of_ratios(values, reference);
  } else {  // must hold for every view
    value = constraint.at_most ? *std::max_element(values.begin(), values.end())
                               : *std::min_element(values.begin(), values.end());
  }
  if (constraint.at_most ? value <= constraint.bound : value >= constraint.bound) return;
  verdict.kind = Verdict::Kind::refused;
  if (verdict.reason.empty()) verdict.reason = constraint.text;
  verdict.excess += constraint.bound == 0.0 ? std::fabs(value) : std::fabs(value / constraint.bound - 1.0);
}

std::vector<Verdict> Stage::judge(const std::vector<Coordinates>& designs, const std::string& what,
                                  CostlyDesigns costly) {
  const auto is_simulated = [&](const Verdict& verdict) {
    return verdict.kind == Verdict::Kind::measured ||
           (verdict.kind == Verdict::Kind::refused && costly == CostlyDesigns::simulate);
  };
  SweepPoints batch;
  std::set<std::string> traces;
  const auto run = [&](const DesignPoints& design) {
    for (const PointMaker::TracedPoint& made : design) {
      if (!requested_.insert(made.point.key).second) continue;
      if (traces.insert(made.trace->key).second) batch.traces.push_back(made.trace);
      batch.points.push_back(made.point);
    }
  };
  run(reference_);
  std::vector<DesignPoints> all;
  std::vector<Verdict> verdicts;
  for (const Coordinates& design : designs) {
    all.push_back(make(design));
    verdicts.push_back(check_costs(all.back()));
    if (is_simulated(verdicts.back())) run(all.back());
  }
  if (!batch.points.empty()) session_.run(batch, what);
  if (reference_values_.empty()) read_reference();
  for (std::size_t i = 0; i < designs.size(); ++i) {
    if (is_simulated(verdicts[i])) verdicts[i] = measure(all[i]);
  }
  return verdicts;
}

void Stage::read_reference() {
  SweepDatabase& database = session_.database();
  for (const PointMaker::TracedPoint& made : reference_) {
    const std::string& key = made.point.key;
    if (const std::string status = database.status_of_point(key); status != "done") {
      throw Error(plan_.path, search_.reference_place,
                  fmt::format("the reference did not run on {}: {}: {}", made.point.scene, status,
                              database.reason_of_point(key)));
    }
    const std::vector<std::string> known = database.value_names(key);
    const auto read = [&](const std::string& name, const std::string& place, bool divides) {
      check_name(name, place, known);
      const double value = database.value(key, name);
      if (divides && !(value > 0.0)) {
        throw Error(plan_.path, place,
                    fmt::format("{} must be above 0 at the reference, on {}", name, made.point.scene));
      }
      return value;
    };
    std::map<std::string, double> values;
    for (const SearchObjective& o : search_.objectives) values[o.value] = read(o.value, o.place, true);
    for (const SearchConstraint& c : search_.constraints) values[c.value] = read(c.value, c.place, c.relative);
    for (const auto& [name, value] : values) reference_values_[name].push_back(value);
  }
}

Verdict Stage::measure(const DesignPoints& design) const {
  Verdict verdict;
  SweepDatabase& database = session_.database();
  for (const PointMaker::TracedPoint& made : design) {
    const std::string status = database.status_of_point(made.point.key);
    if (status == "done") continue;
    const std::string reason = database.reason_of_point(made.point.key);
    // The machine does not support this trace, which is only known after tracing: not a failed run.
    constexpr std::string_view kNoMachine = "sim: configuration: ";
    if (status == "failed" && reason.starts_with(kNoMachine)) {
      return {Verdict::Kind::broken, reason.substr(kNoMachine.size()), 0.0, {}};
    }
    verdict.kind = Verdict::Kind::failed;
    verdict.reason = fmt::format("{}: {}", status, reason);
    return verdict;
  }
  const auto values = [&](const std::string& name) {
    std::vector<double> list;
    for (const PointMaker::TracedPoint& made : design) list.push_back(database.value(made.point.key, name));
    return list;
  };
  try {
    for (const SearchObjective& objective : search_.objectives) {
      verdict.ratios.push_back(
          geometric_mean_of_ratios(values(objective.value), reference_values_.at(objective.value)));
    }
    for (const SearchConstraint& constraint : search_.constraints) {
      apply(constraint, values(constraint.value), reference_values_.at(constraint.value), verdict);
    }
  } catch (const Error& error) {  // only some machines have the statistic
    return {Verdict::Kind::failed, error.rule(), 0.0, {}};
  }
  return verdict;
}

std::vector<Stage::View> Stage::reference() const {
  std::vector<View> views;
  for (std::size_t i = 0; i < reference_.size(); ++i) {
    View view = {reference_[i].point.scene, maker_.places()[i].view, {}};
    for (const SearchObjective& objective : search_.objectives) {
      view.values.push_back(reference_values_.at(objective.value)[i]);
    }
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace grtx::explore
