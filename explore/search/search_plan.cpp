// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/search/search_plan.h"
#include "grtx/explore/sweep/designs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <regex>

#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"
#include "grtx/explore/sweep/plan_sections.h"

namespace grtx::explore {
namespace {

constexpr double kMaxValues = 10'000;  ///< limit per parameter: more is a typing error

class SearchPlanReader {
 public:
  SearchPlanReader(const std::string& path, const TracerRules& tracer)
      : in_(path, tracer, PlanSections::Roles::search_and_evaluation) {}

  SearchPlan read() {
    const toml::node* reference = nullptr;
    for (const auto& [name, node] : in_.parse()) {
      if (in_.read(name, *node)) continue;
      if (name == "parameter") {
        for (const toml::table* table : in_.tables_of(*node, name)) read_parameter(*table);
      } else if (name == "objective") {
        for (const toml::table* table : in_.tables_of(*node, name)) read_objective(*table);
      } else if (name == "constraint") {
        for (const toml::table* table : in_.tables_of(*node, name)) read_constraint(*table);
      } else if (name == "reference") {
        reference = node;
      } else if (name == "search") {
        read_search(in_.table_of(*node, name));
      } else {
        std::vector<std::string> known = PlanSections::names();
        known.insert(known.end(), {"parameter", "objective", "constraint", "reference", "search"});
        in_.unknown(*node, name, known);
      }
    }
    if (reference == nullptr) missing("reference", "[reference] is needed: the design that all are compared with");
    read_reference(in_.table_of(*reference, "reference"));
    if (in_.plan.scenes.empty()) missing("scene", "at least one [[scene]] is needed");
    if (std::all_of(in_.plan.scenes.begin(), in_.plan.scenes.end(), [](const PlanScene& s) { return s.evaluation; })) {
      missing("scene", "at least one [[scene]] with role = \"search\" is needed");
    }
    if (plan_.parameters.empty()) missing("parameter", "at least one [[parameter]] is needed");
    if (plan_.objectives.empty()) missing("objective", "at least one [[objective]] is needed");
    if ((plan_.generations == 0) == (plan_.candidates == 0)) {
      missing("search", "[search] needs either generations or candidates");
    }
    if (in_.sets_design && !design_place_.empty()) {
      throw Error(in_.plan.path, design_place_,
                  "design: names accel and checkpoint; tracer.accel and tracer.checkpoint must not be set too");
    }
    if (in_.sets_design) in_.plan.designs.clear();
    for (const PlanScene& scene : in_.plan.scenes) check_screening(scene);
    plan_.common = in_.plan;
    plan_.common.area = area();
    return plan_;
  }

 private:
  /// The area that the search is about: the first among its objectives, then constraints.
  std::string area() const {
    const auto is_area = [](const std::string& value) { return value == kChipArea || value == kRtUnitArea; };
    for (const SearchObjective& objective : plan_.objectives) {
      if (is_area(objective.value)) return objective.value;
    }
    for (const SearchConstraint& constraint : plan_.constraints) {
      if (is_area(constraint.value)) return constraint.value;
    }
    return kChipArea;
  }

  [[noreturn]] void missing(const std::string& what, const std::string& rule) const {
    throw Error(in_.plan.path, what, rule);
  }

  /// A smaller image needs to know the size of the whole one.
  void check_screening(const PlanScene& scene) const {
    if (plan_.screening_scale == 1.0 || scene.evaluation || (scene.width > 0 && scene.height > 0)) return;
    throw Error(in_.plan.path, scene.place, "scene: search.screening_scale needs width and height");
  }

  void check_value(const toml::node& node, const std::string& key, const SweepValue& value) {
    if (key == kDesign && design_place_.empty()) design_place_ = place_of(node);
    in_.check_varied(node, key, value);
  }

  void read_parameter(const toml::table& table) {
    SearchParameter parameter;
    std::optional<double> min, max, step;
    const toml::node* list = nullptr;
    bool integers = true;
    std::string kind;
    const auto range = [&](const toml::node& node, const std::string& full, double low) {
      integers = integers && node.is_integer();
      return in_.number(node, full, low, 1e15);
    };
    for (const auto& [name, node] : PlanSections::sorted(table)) {
      const std::string full = "parameter." + name;
      if (name == "key") {
        parameter.key = in_.text(*node, full);
      } else if (name == "values") {
        list = node;
      } else if (name == "min") {
        min = range(*node, full, -1e15);
      } else if (name == "max") {
        max = range(*node, full, -1e15);
      } else if (name == "step") {
        step = range(*node, full, 1e-15);
      } else if (name == "kind") {
        kind = in_.one_of(*node, full, {"ordered", "categorical"});
      } else {
        in_.unknown(*node, full,
                    {"parameter.key", "parameter.values", "parameter.min", "parameter.max", "parameter.step",
                     "parameter.kind"});
      }
    }
    const std::string& key = parameter.key;
    if (key.empty()) {
      in_.fail(table, "parameter: key is needed: a configuration key, tracer.OPTION, design or machine");
    }
    for (const SearchParameter& other : plan_.parameters) {
      if (other.key == key) in_.fail(table, fmt::format("parameter: two have the key '{}'", key));
    }
    const bool whole_range = min && max && step, no_range = !min && !max && !step;
    if (list != nullptr ? !no_range : !whole_range) {
      in_.fail(table, key + ": needs either values, or min, max and step");
    }
    const toml::node& node = list != nullptr ? *list : static_cast<const toml::node&>(table);
    parameter.values =
        list != nullptr ? in_.scalars(*list, key) : range_values(table, key, *min, *max, *step, integers);
    for (const SweepValue& value : parameter.values) check_value(node, key, value);
    for (std::size_t i = 0; i < parameter.values.size(); ++i) {
      if (std::find(parameter.values.begin(), parameter.values.begin() + static_cast<std::ptrdiff_t>(i),
                    parameter.values[i]) != parameter.values.begin() + static_cast<std::ptrdiff_t>(i)) {
        in_.fail(node, fmt::format("{}: the value {} is there twice", key, text_of(parameter.values[i])));
      }
    }
    if (parameter.values.size() < 2) in_.fail(node, key + ": needs two values or more; a single one belongs to [set]");
    const bool numbers = std::all_of(parameter.values.begin(), parameter.values.end(),
                                     [](const SweepValue& value) { return value.is_number(); });
    parameter.ordered = kind.empty() ? numbers : kind == "ordered";
    plan_.parameters.push_back(std::move(parameter));
  }

  std::vector<SweepValue> range_values(const toml::table& table, const std::string& key, double min, double max,
                                       double step, bool integers) const {
    if (min > max) in_.fail(table, key + ": min must not be above max");
    const double count = std::floor((max - min) / step * (1.0 + 1e-12)) + 1.0;
    if (count > kMaxValues) in_.fail(table, fmt::format("{}: more than {} values", key, kMaxValues));
    std::vector<SweepValue> values;
    for (double i = 0.0; i < count; ++i) {
      if (integers) {
        values.emplace_back(std::llround(min + i * step));
      } else {
        values.emplace_back(nine_digits(min + i * step));
      }
    }
    return values;
  }

  void read_objective(const toml::table& table) {
    SearchObjective objective;
    objective.place = place_of(table);
    for (const auto& [name, node] : PlanSections::sorted(table)) {
      if (name == "value") {
        objective.value = in_.text(*node, "objective.value");
        objective.place = place_of(*node);
      } else {
        in_.unknown(*node, "objective." + name, {"objective.value"});
      }
    }
    if (objective.value.empty()) in_.fail(table, "objective: value is needed: a statistic or cost.*");
    for (const SearchObjective& other : plan_.objectives) {
      if (other.value == objective.value) in_.fail(table, "objective: two are " + objective.value);
    }
    plan_.objectives.push_back(objective);
  }

  void read_constraint(const toml::table& table) {
    SearchConstraint constraint;
    for (const auto& [name, node] : PlanSections::sorted(table)) {
      if (name != "rule") in_.unknown(*node, "constraint." + name, {"constraint.rule"});
      constraint.text = in_.text(*node, "constraint.rule");
      constraint.place = place_of(*node);
      static const std::regex form(
          R"(\s*([A-Za-z_][\w.]*)\s*(<=|>=)\s*(?:([0-9][0-9.eE+-]*)\s*(\*\s*reference)?|(reference))\s*)");
      std::smatch parts;
      char* end = nullptr;
      const bool fits = std::regex_match(constraint.text, parts, form);
      const std::string number = fits && parts[3].matched ? parts[3].str() : "1";
      constraint.bound = std::strtod(number.c_str(), &end);
      if (!fits || *end != '\0' || !std::isfinite(constraint.bound)) {
        in_.fail(*node, fmt::format("constraint.rule: must be VALUE <= NUMBER or VALUE <= FACTOR * reference (or >=), "
                                    "not '{}'",
                                    constraint.text));
      }
      constraint.value = parts[1].str();
      constraint.at_most = parts[2].str() == "<=";
      constraint.relative = parts[4].matched || parts[5].matched;
    }
    if (constraint.text.empty()) in_.fail(table, "constraint: rule is needed, e.g. cost.mm2 <= 1.1 * reference");
    plan_.constraints.push_back(constraint);
  }

  void read_reference(const toml::table& table) {
    plan_.reference_place = place_of(table);
    std::vector<std::string> keys;
    for (const SearchParameter& parameter : plan_.parameters) keys.push_back(parameter.key);
    Coordinates given;
    in_.each_name(table, "", [&](const std::string& name, const toml::node& node) {
      if (std::find(keys.begin(), keys.end(), name) == keys.end()) {
        in_.fail(node, fmt::format("reference: '{}' is no [[parameter]], the nearest is '{}'; what all designs have "
                                   "belongs to [set]",
                                   name, nearest_name(name, keys)));
      }
      const SweepValue value = in_.scalar(node, name);
      check_value(node, name, value);
      given.emplace_back(name, value);
    });
    for (const std::string& key : keys) {  // in the order of the parameters, as candidates are
      for (const auto& [name, value] : given) {
        if (name == key) plan_.reference.emplace_back(name, value);
      }
    }
  }

  void read_search(const toml::table& table) {
    constexpr std::int64_t kMax = 1'000'000;
    for (const auto& [name, node] : PlanSections::sorted(table)) {
      const std::string full = "search." + name;
      const auto count = [&, full = full, node = node](std::int64_t min) {
        return static_cast<unsigned>(in_.integer(*node, full, min, kMax));
      };
      if (name == "seed") {
        plan_.seed = static_cast<unsigned>(in_.integer(*node, full, 0, std::numeric_limits<std::uint32_t>::max()));
      } else if (name == "population") {
        plan_.population = count(8);
        if (plan_.population % 4 != 0) in_.fail(*node, full + ": must be a multiple of 4");
      } else if (name == "generations") {
        plan_.generations = count(1);
      } else if (name == "candidates") {
        plan_.candidates = count(1);
      } else if (name == "screening_scale") {
        plan_.screening_scale = in_.number(*node, full, 0.01, 1.0);
      } else if (name == "screening") {
        in_.read_settings(in_.table_of(*node, full), "", plan_.screening);
      } else if (name == "confirm") {
        plan_.confirm = in_.text(*node, full);
      } else if (name == "margin") {
        plan_.margin = in_.number(*node, full, 0.0, 1.0);
      } else if (name == "path") {
        plan_.path = in_.boolean(*node, full);
      } else {
        in_.unknown(*node, full,
                    {"search.seed", "search.population", "search.generations", "search.candidates", "search.screening",
                     "search.screening_scale", "search.confirm", "search.margin", "search.path"});
      }
    }
  }

  PlanSections in_;
  SearchPlan plan_;
  std::string design_place_;
};

}  // namespace

SearchPlan load_search_plan(const std::string& path, const TracerRules& tracer) {
  return SearchPlanReader(path, tracer).read();
}

}  // namespace grtx::explore
