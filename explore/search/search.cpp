// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/search/search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <optional>

#include "grtx/base/json.h"
#include "grtx/explore/search/main_effects.h"
#include "grtx/explore/search/nsga2.h"
#include "grtx/explore/search/stage.h"
#include "grtx/explore/sweep/dominance.h"

namespace grtx::explore {
namespace {

using nlohmann::ordered_json;

/// Costs of designs that break a constraint: above all ratios, ordered by the violation (Deb's constrained domination).
constexpr double kRefusedCost = 1e6;
/// Costs of designs that do not run.
constexpr double kFailedCost = 1e12;
constexpr unsigned kIdleGenerations = 50;  ///< generations without a new design that end the search

struct Candidate {
  Choices choices;
  Coordinates coordinates;
  unsigned generation = 0;
  Verdict screened;
  std::optional<Verdict> confirmed, evaluated;
};

/// A step on the path from the reference to the best design.
struct Step {
  std::string key;
  ordered_json from, to;  ///< `from` is null: the value of the base
  Verdict verdict;        ///< after the change
  bool together = false;  ///< taken together with the next step, as neither runs alone
};

ordered_json json_of(const Coordinates& coordinates) {
  ordered_json json = ordered_json::object();
  for (const auto& [name, value] : coordinates) json[name] = value;
  return json;
}

ordered_json json_of(const Verdict& verdict) {
  ordered_json json = {{"outcome", name_of(verdict.kind)}};
  if (!verdict.reason.empty()) json["reason"] = verdict.reason;
  if (!verdict.ratios.empty()) json["ratios"] = verdict.ratios;
  return json;
}

ordered_json json_of(const std::vector<Stage::View>& views) {
  ordered_json json = ordered_json::array();
  for (const Stage::View& view : views) {
    json.push_back({{"scene", view.scene}, {"view", view.view}, {"values", view.values}});
  }
  return json;
}

const SweepValue* value_of(const Coordinates& coordinates, const std::string& key) {
  for (const auto& [name, value] : coordinates) {
    if (name == key) return &value;
  }
  return nullptr;
}

class Search {
 public:
  Search(const SearchPlan& plan, const TracerRules& tracer, SweepSession& session, bool quiet)
      : plan_(plan),
        quiet_(quiet),
        screening_(screening_plan(plan), plan, tracer, session, prices_),
        confirming_(confirming_plan(plan), plan, tracer, session, prices_) {
    for (const SearchParameter& parameter : plan.parameters) {
      space_.dimensions.push_back({parameter.values.size(), parameter.ordered});
    }
    if (SweepPlan own = evaluation_plan(plan); !own.scenes.empty()) {
      evaluation_.emplace(std::move(own), plan, tracer, session, prices_);
    }
  }

  ordered_json run() {
    // Names of values, and that the reference has more than 0 of each, are checked before candidates are simulated.
    for (Stage* stage : {&screening_, &confirming_}) stage->judge({}, "reference");
    if (evaluation_) evaluation_->judge({}, "reference");
    screen();
    confirm();
    evaluate();
    if (plan_.path) find_path();
    return result();
  }

 private:
  Coordinates coordinates_of(const Choices& choices) const {
    Coordinates coordinates;
    for (std::size_t i = 0; i < choices.size(); ++i) {
      coordinates.emplace_back(plan_.parameters[i].key, plan_.parameters[i].values[choices[i]]);
    }
    return coordinates;
  }

  /// The reference as choices, if it lies in the search space.
  std::vector<Choices> first() const {
    Choices choices;
    for (const SearchParameter& parameter : plan_.parameters) {
      const SweepValue* value = value_of(plan_.reference, parameter.key);
      const auto found = value == nullptr ? parameter.values.end()
                                          : std::find(parameter.values.begin(), parameter.values.end(), *value);
      if (found == parameter.values.end()) return {};
      choices.push_back(static_cast<std::size_t>(found - parameter.values.begin()));
    }
    return {choices};
  }

  std::vector<std::vector<double>> costs_of(const std::vector<Choices>& designs) {
    std::vector<Coordinates> unknown;
    for (const Choices& choices : designs) {
      if (!index_.emplace(choices, candidates_.size()).second) continue;
      Candidate candidate;
      candidate.choices = choices;
      candidate.coordinates = coordinates_of(choices);
      candidate.generation = generation_;
      unknown.push_back(candidate.coordinates);
      candidates_.push_back(std::move(candidate));
    }
    const std::vector<Verdict> verdicts = screening_.judge(unknown, fmt::format("generation {}", generation_));
    for (std::size_t i = 0; i < verdicts.size(); ++i) {
      candidates_[candidates_.size() - verdicts.size() + i].screened = verdicts[i];
    }
    std::vector<std::vector<double>> costs;
    for (const Choices& choices : designs) {
      const Verdict& verdict = candidates_[index_.at(choices)].screened;
      switch (verdict.kind) {
        case Verdict::Kind::measured:
          costs.push_back(verdict.ratios);
          break;
        case Verdict::Kind::refused:
          costs.emplace_back(plan_.objectives.size(), kRefusedCost * (1.0 + verdict.excess));
          break;
        default:
          costs.emplace_back(plan_.objectives.size(), kFailedCost);
      }
    }
    return costs;
  }

  void screen() {
    Nsga2 nsga2(space_, plan_.seed, plan_.population, plan_.objectives.size(), first(),
                [this](const std::vector<Choices>& designs) { return costs_of(designs); });
    for (unsigned idle = 0; idle < kIdleGenerations;) {
      const std::size_t before = nsga2.evaluated_count();
      if (!quiet_) {
        fmt::print(stderr, "generation {}: {} candidates, {} on the front\n", generation_, before, front().size());
      }
      if (plan_.generations != 0 && generation_ == plan_.generations) break;
      if (plan_.candidates != 0 && before >= plan_.candidates) break;
      if (static_cast<double>(before) >= space_.size()) break;
      ++generation_;
      nsga2.step();
      idle = nsga2.evaluated_count() == before ? idle + 1 : 0;
    }
  }

  /// Screened candidates that stay non-dominated if others are worse by the margin; of equal ones the first.
  std::vector<std::size_t> front() const {
    std::vector<std::size_t> list;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      if (candidates_[i].screened.kind != Verdict::Kind::measured) continue;
      const std::vector<double>& ratios = candidates_[i].screened.ratios;
      bool dominated = false;
      for (std::size_t o = 0; o < candidates_.size() && !dominated; ++o) {
        if (candidates_[o].screened.kind != Verdict::Kind::measured) continue;
        std::vector<double> other = candidates_[o].screened.ratios;
        dominated = o < i && other == ratios;
        for (double& ratio : other) ratio *= 1.0 + plan_.margin;
        dominated = dominated || dominates(other, ratios);
      }
      if (!dominated) list.push_back(i);
    }
    return list;
  }

  void confirm() {
    const std::vector<std::size_t> chosen = front();
    std::vector<Coordinates> designs;
    for (const std::size_t i : chosen) designs.push_back(candidates_[i].coordinates);
    const std::vector<Verdict> verdicts = confirming_.judge(designs, "confirming");
    std::vector<std::vector<double>> ratios(verdicts.size());
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      candidates_[chosen[i]].confirmed = verdicts[i];
      if (verdicts[i].kind == Verdict::Kind::measured) ratios[i] = verdicts[i].ratios;
    }
    const std::vector<bool> on_front = non_dominated(ratios);
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      if (on_front[i]) front_.push_back(chosen[i]);
    }
    std::stable_sort(front_.begin(), front_.end(), [&](std::size_t a, std::size_t b) {
      return candidates_[a].confirmed->ratios < candidates_[b].confirmed->ratios;
    });
  }

  void evaluate() {
    if (!evaluation_ || front_.empty()) return;
    std::vector<Coordinates> designs;
    for (const std::size_t i : front_) designs.push_back(candidates_[i].coordinates);
    const std::vector<Verdict> verdicts = evaluation_->judge(designs, "evaluation");
    for (std::size_t i = 0; i < front_.size(); ++i) candidates_[front_[i]].evaluated = verdicts[i];
  }

  /// Greedy path from the reference to the best design: the most beneficial change first.
  void find_path() {
    if (front_.empty()) return;
    const Coordinates& best = candidates_[front_.front()].coordinates;
    std::vector<std::string> remaining;
    for (const auto& [key, value] : best) {
      const SweepValue* before = value_of(plan_.reference, key);
      if (before == nullptr || *before != value) remaining.push_back(key);
    }
    Coordinates current = plan_.reference;
    while (!remaining.empty()) {
      std::vector<Coordinates> designs;
      for (const std::string& key : remaining) designs.push_back(with(current, best, key));
      const std::vector<Verdict> verdicts = confirming_.judge(
          designs, fmt::format("path, {} changes left", remaining.size()), Stage::CostlyDesigns::simulate);
      std::size_t chosen = remaining.size();
      for (std::size_t i = 0; i < remaining.size(); ++i) {
        if (verdicts[i].ratios.empty()) continue;
        if (chosen == remaining.size() || verdicts[i].ratios < verdicts[chosen].ratios) chosen = i;
      }
      const bool none_runs = chosen == remaining.size();  // no change runs alone: the first is combined with the next
      if (none_runs) chosen = 0;
      const std::string key = remaining[chosen];
      const SweepValue* before = value_of(current, key);
      path_.push_back(
          {key, before == nullptr ? ordered_json() : *before, *value_of(best, key), verdicts[chosen], none_runs});
      current = designs[chosen];
      remaining.erase(remaining.begin() + static_cast<std::ptrdiff_t>(chosen));
    }
  }

  /// A copy of a design with one value taken from another, in the order of the parameters.
  Coordinates with(const Coordinates& design, const Coordinates& other, const std::string& key) const {
    Coordinates changed;
    for (const SearchParameter& parameter : plan_.parameters) {
      const SweepValue* value = value_of(parameter.key == key ? other : design, parameter.key);
      if (value != nullptr) changed.emplace_back(parameter.key, *value);
    }
    return changed;
  }

  ordered_json effects() const {
    ordered_json list = ordered_json::array();
    for (std::size_t o = 0; o < plan_.objectives.size(); ++o) {
      std::vector<Choices> designs;
      std::vector<double> costs;
      for (const Candidate& candidate : candidates_) {
        if (candidate.screened.ratios.empty() || candidate.screened.ratios[o] <= 0.0) continue;  // 0 has no logarithm
        designs.push_back(candidate.choices);
        costs.push_back(candidate.screened.ratios[o]);
      }
      const MainEffects model = main_effects(space_, designs, costs);
      ordered_json parameters = ordered_json::array();
      for (std::size_t p = 0; p < plan_.parameters.size(); ++p) {
        ordered_json values = ordered_json::array();
        for (std::size_t c = 0; c < plan_.parameters[p].values.size(); ++c) {
          if (model.designs[p][c] == 0) continue;
          values.push_back({{"value", plan_.parameters[p].values[c]},
                            {"candidates", model.designs[p][c]},
                            {"factor", model.factors[p][c]}});
        }
        parameters.push_back({{"key", plan_.parameters[p].key}, {"values", std::move(values)}});
      }
      list.push_back({{"objective", plan_.objectives[o].value},
                      {"explained", model.explained},
                      {"parameters", std::move(parameters)}});
    }
    return list;
  }

  /// Candidates that did not finish or broke a constraint, counted by reason, the most frequent first.
  ordered_json invalid() const {
    std::map<std::pair<std::string, std::string>, std::size_t> counts;
    for (const Candidate& candidate : candidates_) {
      const Verdict& verdict = candidate.screened;
      if (verdict.kind == Verdict::Kind::measured) continue;
      ++counts[{std::string(name_of(verdict.kind)), verdict.reason}];
    }
    std::vector<ordered_json> list;
    for (const auto& [what, count] : counts) {
      list.push_back({{"outcome", what.first}, {"reason", what.second}, {"candidates", count}});
    }
    std::stable_sort(list.begin(), list.end(), [](const ordered_json& a, const ordered_json& b) {
      return a.at("candidates").get<std::size_t>() > b.at("candidates").get<std::size_t>();
    });
    return list;
  }

  ordered_json counts() const {
    const auto count = [&](auto&& what) { return std::count_if(candidates_.begin(), candidates_.end(), what); };
    const auto of_kind = [&](Verdict::Kind kind) {
      return count([kind](const Candidate& c) { return c.screened.kind == kind; });
    };
    return {{"space", space_.size()},
            {"generations", generation_},
            {"candidates", candidates_.size()},
            {"broken", of_kind(Verdict::Kind::broken)},
            {"too_dear", count([](const Candidate& c) {
               return c.screened.kind == Verdict::Kind::refused && c.screened.ratios.empty();
             })},
            {"screened", count([](const Candidate& c) { return !c.screened.ratios.empty(); })},
            {"failed", of_kind(Verdict::Kind::failed)},
            {"confirmed", count([](const Candidate& c) { return c.confirmed.has_value(); })},
            {"front", front_.size()},
            {"points",
             {{"screening", screening_.points()},
              {"confirming", confirming_.points()},
              {"evaluation", evaluation_ ? evaluation_->points() : 0}}}};
  }

  ordered_json result() const {
    ordered_json objectives = ordered_json::array(), constraints = ordered_json::array(),
                 parameters = ordered_json::array(), candidates = ordered_json::array(), path = ordered_json::array();
    for (const SearchObjective& objective : plan_.objectives) objectives.push_back(objective.value);
    for (const SearchConstraint& constraint : plan_.constraints) constraints.push_back(constraint.text);
    for (const SearchParameter& parameter : plan_.parameters) {
      parameters.push_back({{"key", parameter.key}, {"values", parameter.values}, {"ordered", parameter.ordered}});
    }
    for (const Candidate& candidate : candidates_) {
      ordered_json json = {{"coordinates", json_of(candidate.coordinates)},
                           {"generation", candidate.generation},
                           {"screening", json_of(candidate.screened)}};
      if (candidate.confirmed) json["confirming"] = json_of(*candidate.confirmed);
      if (candidate.evaluated) json["evaluation"] = json_of(*candidate.evaluated);
      candidates.push_back(std::move(json));
    }
    for (const Step& step : path_) {
      ordered_json json = {{"key", step.key}, {"from", step.from}, {"to", step.to}};
      json.update(json_of(step.verdict));
      if (step.together) json["together"] = true;
      path.push_back(std::move(json));
    }
    ordered_json reference = {{"coordinates", json_of(plan_.reference)},
                              {"screening", json_of(screening_.reference())},
                              {"confirming", json_of(confirming_.reference())}};
    if (evaluation_ && !front_.empty()) reference["evaluation"] = json_of(evaluation_->reference());
    ordered_json screening = json_of(plan_.screening);
    return {
        {"schema", "grtx.search/1"},
        {"program", program_version()},
        {"machine", plan_.common.machines.empty() ? plan_.common.machine.name : ""},  // else each candidate's own
        {"seed", plan_.seed},
        {"population", plan_.population},
        {"margin", plan_.margin},
        {"screening", {{"mode", plan_.common.mode}, {"scale", plan_.screening_scale}, {"set", std::move(screening)}}},
        {"confirming", {{"mode", plan_.confirm}}},
        {"objectives", std::move(objectives)},
        {"constraints", std::move(constraints)},
        {"parameters", std::move(parameters)},
        {"reference", std::move(reference)},
        {"counts", counts()},
        {"invalid", invalid()},
        {"front", front_},
        {"candidates", std::move(candidates)},
        {"effects", effects()},
        {"path", std::move(path)}};
  }

  const SearchPlan& plan_;
  bool quiet_;
  Prices prices_;
  Stage screening_, confirming_;
  std::optional<Stage> evaluation_;
  SearchSpace space_;
  unsigned generation_ = 0;
  std::vector<Candidate> candidates_;  ///< in order of evaluation
  std::map<Choices, std::size_t> index_;
  std::vector<std::size_t> front_;  ///< indices of confirmed candidates, sorted by the first objective
  std::vector<Step> path_;
};

}  // namespace

ordered_json run_search(const SearchPlan& plan, const TracerRules& tracer, SweepSession& session, bool quiet) {
  ordered_json result = Search(plan, tracer, session, quiet).run();
  session.database().set_meta("search", json_text(result));
  return result;
}

bool search_succeeded(const ordered_json& result) {
  return !result.at("front").empty() && result.at("counts").at("failed").get<std::size_t>() == 0;
}

}  // namespace grtx::explore
