// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/sweep_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <string_view>

#include "grtx/base/geometric_mean.h"
#include "grtx/base/json.h"
#include "grtx/explore/sweep/axis.h"
#include "grtx/explore/sweep/designs.h"
#include "grtx/explore/sweep/dominance.h"
#include "grtx/rtl_tlm/run/statistics_reference.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kFew = 4;  // maximum coordinates in a name
constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

bool is_view(const std::string& coordinate) {
  constexpr std::array<std::string_view, 6> kNames = {"view", "width", "height", "fov_scale", "scene", "mode"};
  return std::find(kNames.begin(), kNames.end(), coordinate) != kNames.end();
}

/// A view: its title, and a text that identifies it uniquely.
struct ViewName {
  std::string title, text;
  bool operator==(const ViewName&) const = default;
};
ViewName view_of(const ReportedPoint& p, const Subject& subject) {
  const auto coordinate = [&p](const char* name) {
    return p.coordinates.contains(name) ? explore::text_of(p.coordinates.at(name)) : std::string();
  };
  std::string title = p.scene;
  if (!coordinate("view").empty()) title += ", view " + coordinate("view");
  if (const std::string width = coordinate("width"), height = coordinate("height"); !width.empty() || !height.empty()) {
    const auto size = [&](const std::string& own, const char* name) {
      return own.empty() ? subject.setting(name) : own;
    };
    title += ", " + size(width, "width") + " × " + size(height, "height");
  }
  if (!coordinate("fov_scale").empty()) title += ", fov_scale = " + coordinate("fov_scale");
  return {title, title + "\n" + subject.view_text()};
}

/// Options of the tracer and keys that designs bring with them: no difference between designs. Those that a plan
/// varies are coordinates.
const std::set<std::string>& brought_by_designs() {
  static const std::set<std::string> names = [] {
    std::set<std::string> all;
    for (const explore::Design& design : explore::designs()) {
      for (const auto& [name, value] : design.tracer) all.insert(name);
      for (const auto& [name, value] : explore::keys_for(design, 1)) all.insert(name);
    }
    return all;
  }();
  return names;
}

/// Key of a point without design, view and mode.
std::string keys_of(const ReportedPoint& p, const Subject& subject) {
  std::map<std::string, std::string> sorted;
  for (const auto& [name, value] : p.coordinates.items()) {
    if (!is_view(name) && name != "design") sorted[name] = json_text(value);
  }
  std::string text = p.machine;
  for (const auto& [name, value] : sorted) text.append("\n").append(name).append("=").append(value);
  return text + "\n" + subject.settings_text(brought_by_designs());
}

/// Design and coordinates of a point, without machine, view and mode.
std::string varied_of(const ReportedPoint& p) {
  std::map<std::string, std::string> sorted;
  for (const auto& [name, value] : p.coordinates.items()) {
    if (!is_view(name)) sorted[name] = json_text(value);
  }
  std::string text = p.design;
  for (const auto& [name, value] : sorted) text.append("\n").append(name).append("=").append(value);
  return text;
}

template <typename T>
std::size_t position_in(std::vector<T>& list, const T& value) {
  const auto found = std::find(list.begin(), list.end(), value);
  if (found != list.end()) return static_cast<std::size_t>(found - list.begin());
  list.push_back(value);
  return list.size() - 1;
}

/// Whether a statistic is declared as a share of a whole, which may be 0.
bool is_share(const std::string& statistic) {
  const modules::Statistic* declared = sim::declared_statistic(statistic);
  return declared != nullptr && declared->kind == modules::StatisticKind::share;
}

}  // namespace

std::string owner_of(const std::string& area) { return area == explore::kRtUnitArea ? "an RT unit" : "the chip"; }

Subject subject_of(const SweepResults& results, const ReportedPoint& point) {
  const auto version = results.meta.find("model_version");
  return {point.inputs,
          point.config,
          {{"machine", point.machine},
           {"mode", point.mode},
           {"model_version", version == results.meta.end() ? "" : version->second}}};
}

std::string but_for_mode(const SweepResults& results, const ReportedPoint& point) {
  const Subject subject = subject_of(results, point);
  return point.design + "\n" + view_of(point, subject).text + "\n" + keys_of(point, subject);
}

SweepViews::SweepViews(const SweepResults& results) : results_(results) {
  find_varying();
  std::map<std::string, std::size_t> keys, machines, varied;  // numbered in order of appearance
  std::vector<std::string> modes;
  for (const ReportedPoint& p : results.points) {
    if (p.done()) position_in(modes, p.mode);
  }
  std::int64_t means = 0;
  for (const std::string& mode : modes) {
    const std::string suffix = modes.size() > 1 ? ", " + mode : "";
    std::vector<ViewName> names;                            // views of this mode
    std::vector<ShownPoint> own;                            // their `view` is an index in names
    std::map<std::size_t, std::vector<std::size_t>> found;  // ShownPoint::machine -> points, at most one per view
    for (std::size_t i = 0; i < results.points.size(); ++i) {
      const ReportedPoint& p = results.points[i];
      if (!p.done() || p.mode != mode) continue;
      const Subject subject = subject_of(results, p);
      ShownPoint point{.id = p.id,
                       .label = fmt::format("#{}", p.id),
                       .view = position_in(names, view_of(p, subject)),
                       .setting = keys.try_emplace(keys_of(p, subject), keys.size()).first->second,
                       .varied = varied.try_emplace(varied_of(p), varied.size()).first->second,
                       .points = {i}};
      const std::string machine = fmt::format("{} {}", point.setting, p.design);
      point.machine = machines.try_emplace(machine, machines.size()).first->second;
      found[point.machine].push_back(i);
      own.push_back(std::move(point));
    }
    std::vector<ShownPoint> mean;
    for (const ShownPoint& point : own) {  // ordered by the first point of each
      if (names.size() < 2 || point.points.front() != found[point.machine].front()) continue;
      if (found[point.machine].size() != names.size()) continue;
      ShownPoint all = point;
      all.id = --means;
      all.label = fmt::format("mean {}", -means);
      all.points = found[point.machine];
      mean.push_back(std::move(all));
    }
    if (!mean.empty()) {
      views_.push_back({fmt::format("all {} views{}", names.size(), suffix), names.size()});
      for (ShownPoint& point : mean) point.view = views_.size() - 1;
      points_.insert(points_.end(), mean.begin(), mean.end());
    }
    const std::size_t before = views_.size();
    std::map<std::string, unsigned> titles;
    for (const ViewName& name : names) {
      const unsigned same = ++titles[name.title];  // several, if a scene or camera file was edited
      views_.push_back({name.title + (same == 1 ? "" : fmt::format(" ({})", same)) + suffix, 1});
    }
    for (ShownPoint& point : own) point.view += before;
    points_.insert(points_.end(), own.begin(), own.end());
  }
  find_fronts();
}

ordered_json SweepViews::coordinate(const ReportedPoint& point, const std::string& name) const {
  return point.coordinates.contains(name) ? point.coordinates.at(name) : ordered_json();
}

void SweepViews::find_varying() {
  for (const std::string& name : results_.coordinates) {
    if (is_view(name) || name == "design") continue;
    std::vector<ordered_json> values;
    std::vector<std::size_t> counts;
    for (const ReportedPoint& p : results_.points) {
      const std::size_t at = position_in(values, coordinate(p, name));
      counts.resize(values.size());
      ++counts[at];
    }
    if (values.size() < 2) continue;
    varying_.push_back(name);
    commonest_.push_back(
        values[static_cast<std::size_t>(std::max_element(counts.begin(), counts.end()) - counts.begin())]);
  }
}

void SweepViews::find_fronts() {
  for (std::size_t view = 0; view < views_.size(); ++view) {
    for (const std::size_t i : front(view, results_.area())) points_[i].on_area = true;
    for (const std::size_t i : front(view, kEnergy)) points_[i].on_energy = true;
  }
}

std::vector<std::size_t> SweepViews::front(std::size_t view, const std::string& cost) const {
  std::vector<std::size_t> members;
  std::vector<std::vector<double>> costs;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (points_[i].view != view) continue;
    members.push_back(i);
    costs.push_back({value(points_[i], kTime), value(points_[i], cost)});
  }
  const std::vector<bool> chosen = explore::non_dominated(costs);
  std::vector<std::size_t> front;
  for (std::size_t m = 0; m < members.size(); ++m) {
    if (chosen[m]) front.push_back(members[m]);
  }
  return front;
}

double SweepViews::value(const ShownPoint& point, const std::string& name) const {
  if (point.points.size() == 1) return first(point).value(name);
  std::vector<double> values;
  for (const std::size_t i : point.points) values.push_back(results_.points[i].value(name));
  if (is_share(name)) return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  return geometric_mean(values);
}

double SweepViews::sum(const ShownPoint& point, const std::string& name) const {
  double sum = 0.0;
  for (const std::size_t i : point.points) {
    const double own = results_.points[i].value(name);
    sum += std::isfinite(own) ? own : 0.0;
  }
  return sum;
}

std::string SweepViews::name(const ReportedPoint& point, Named named) const {
  std::vector<std::string> parts;
  if (results_.several(&ReportedPoint::machine)) parts.push_back(point.machine);
  if (results_.several(&ReportedPoint::design)) parts.push_back(point.design);
  std::size_t listed = 0, more = 0;
  for (std::size_t i = 0; i < varying_.size(); ++i) {
    const ordered_json own = coordinate(point, varying_[i]);
    if (own.is_null() || (varying_.size() > kFew && own == commonest_[i])) continue;
    if (named == Named::briefly && listed == kFew) {
      ++more;
      continue;
    }
    ++listed;
    parts.push_back(varying_[i] + " = " + explore::text_of(own));
  }
  if (more != 0) parts.push_back(fmt::format("{} more", more));
  if (listed == 0 && varying_.size() > kFew) parts.push_back("all else as most points have it");
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

std::string SweepViews::full_label(const ShownPoint& point) const {
  const std::string own = name(first(point));
  return point.label + (own.empty() ? "" : " " + own);
}

const ShownPoint* SweepViews::least(const std::string& value_name) const {
  const ShownPoint* best = nullptr;
  for (const ShownPoint& p : points_) {
    const double own = value(p, value_name);
    if (p.view != 0 || !std::isfinite(own)) continue;
    const double lowest = best == nullptr ? own : value(*best, value_name);
    const bool is_named = p.on_front() && !(best != nullptr && best->on_front());
    if (best == nullptr || own < lowest || (own == lowest && is_named)) best = &p;
  }
  return best;
}

SpeedupOver SweepViews::reference() const {
  if (points_.empty()) return {};
  std::vector<std::string> designs;
  for (const ShownPoint& point : points_) position_in(designs, first(point).design);
  if (designs.size() == 1 && results_.several(&ReportedPoint::machine)) {
    return {"", 0, results_.points.front().machine};
  }
  if (designs.size() == 1) return {"", points_.front().machine};
  const bool has_baseline = std::find(designs.begin(), designs.end(), "baseline") != designs.end();
  return {has_baseline ? "baseline" : designs.front(), 0};
}

const ShownPoint* SweepViews::over(const ShownPoint& point, const SpeedupOver& reference) const {
  for (const ShownPoint& other : points_) {
    if (other.view != point.view) continue;
    const ReportedPoint &own = first(point), &its = first(other);
    const bool fits = !reference.on.empty() ? its.machine == reference.on && other.varied == point.varied
                      : reference.design.empty()
                          ? other.machine == reference.machine && its.design == own.design && its.machine == own.machine
                          : other.setting == point.setting && its.design == reference.design;
    if (fits) return &other;
  }
  return nullptr;
}

double SweepViews::speedup(const ShownPoint& point, const SpeedupOver& reference) const {
  const ShownPoint* other = over(point, reference);
  return other == nullptr ? kNoValue : value(*other, kTime) / value(point, kTime);
}

std::optional<Interval> SweepViews::speedup_interval(const ShownPoint& point, const SpeedupOver& reference) const {
  const ShownPoint* other = over(point, reference);
  if (other == nullptr || other == &point) return std::nullopt;
  return ratio_of(time_interval(*other), time_interval(point));
}

std::optional<Interval> SweepViews::time_interval(const ShownPoint& point) const {
  if (point.points.size() != 1) return std::nullopt;
  const auto cycles = cycles_interval([&](const char* name) { return value(point, name); });
  const double scale = value(point, kTime) / value(point, "gpu.cycles");
  if (!cycles || !std::isfinite(scale)) return std::nullopt;
  return Interval{cycles->low * scale, cycles->high * scale};
}

}  // namespace grtx::report
