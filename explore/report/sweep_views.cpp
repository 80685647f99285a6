#include "grtx/explore/report/sweep_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "grtx/base/json.h"
#include "grtx/explore/sweep/axis.h"
#include "grtx/explore/sweep/dominance.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kFew = 4;  // coordinates that a name lists
constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

bool is_view(const std::string& coordinate) {
  return coordinate == "view" || coordinate == "scene" || coordinate == "mode";
}

std::string view_of(const ReportedPoint& p) {
  return p.scene + (p.coordinates.contains("view") ? ", view " + text_of(p.coordinates.at("view")) : "");
}

std::string machine_of(const ReportedPoint& p) {
  std::map<std::string, std::string> sorted;
  for (const auto& [name, value] : p.coordinates.items()) {
    if (!is_view(name)) sorted[name] = json_text(value);
  }
  std::string text = p.design;
  for (const auto& [name, value] : sorted) text += "\n" + name + "=" + value;
  return text;
}

template <typename T>
std::size_t position_in(std::vector<T>& list, const T& value) {
  const auto found = std::find(list.begin(), list.end(), value);
  if (found != list.end()) return static_cast<std::size_t>(found - list.begin());
  list.push_back(value);
  return list.size() - 1;
}

}  // namespace

SweepViews::SweepViews(const SweepResults& results) : results_(results) {
  find_varying();
  std::vector<std::string> machines, modes;
  for (const ReportedPoint& p : results.points) {
    if (p.done()) position_in(modes, p.mode);
  }
  std::int64_t means = 0;
  for (const std::string& mode : modes) {
    const std::string suffix = modes.size() > 1 ? ", " + mode : "";
    std::vector<std::string> names;                         // of the mode's views
    std::vector<ShownPoint> own;                            // view: in names
    std::map<std::size_t, std::vector<std::size_t>> found;  // by machine: points, at most one a view
    for (std::size_t i = 0; i < results.points.size(); ++i) {
      const ReportedPoint& p = results.points[i];
      if (!p.done() || p.mode != mode) continue;
      ShownPoint point{.id = p.id,
                       .label = fmt::format("#{}", p.id),
                       .view = position_in(names, view_of(p)),
                       .machine = position_in(machines, machine_of(p)),
                       .of = {i}};
      found[point.machine].push_back(i);
      own.push_back(std::move(point));
    }
    std::vector<ShownPoint> mean;
    for (const ShownPoint& point : own) {  // in the order of the first point of each
      if (names.size() < 2 || point.of.front() != found[point.machine].front()) continue;
      if (found[point.machine].size() != names.size()) continue;
      ShownPoint all = point;
      all.id = --means;
      all.label = fmt::format("mean {}", -means);
      all.of = found[point.machine];
      mean.push_back(std::move(all));
    }
    if (!mean.empty()) {
      views_.push_back({fmt::format("all {} views{}", names.size(), suffix), names.size()});
      for (ShownPoint& point : mean) point.view = views_.size() - 1;
      points_.insert(points_.end(), mean.begin(), mean.end());
    }
    const std::size_t before = views_.size();
    for (const std::string& name : names) views_.push_back({name + suffix, 1});
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
    std::vector<std::size_t> members;
    std::vector<std::vector<double>> area, energy;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (points_[i].view != view) continue;
      members.push_back(i);
      const double time = value(points_[i], kTime);
      area.push_back({time, value(points_[i], kArea)});
      energy.push_back({time, value(points_[i], kEnergy)});
    }
    const std::vector<bool> on_area = non_dominated(area), on_energy = non_dominated(energy);
    for (std::size_t m = 0; m < members.size(); ++m) {
      points_[members[m]].on_area = on_area[m];
      points_[members[m]].on_energy = on_energy[m];
    }
  }
}

double SweepViews::value(const ShownPoint& point, const std::string& name) const {
  if (point.of.size() == 1) return first(point).value(name);
  double logs = 0.0;
  for (const std::size_t i : point.of) logs += std::log(results_.points[i].value(name));
  return std::exp(logs / static_cast<double>(point.of.size()));
}

double SweepViews::sum(const ShownPoint& point, const std::string& name) const {
  double sum = 0.0;
  for (const std::size_t i : point.of) {
    const double own = results_.points[i].value(name);
    sum += std::isfinite(own) ? own : 0.0;
  }
  return sum;
}

std::string SweepViews::name(const ReportedPoint& point) const {
  std::vector<std::string> parts;
  if (results_.several(&ReportedPoint::design)) parts.push_back(point.design);
  std::size_t listed = 0, more = 0;
  for (std::size_t i = 0; i < varying_.size(); ++i) {
    const ordered_json own = coordinate(point, varying_[i]);
    if (own.is_null() || (varying_.size() > kFew && own == commonest_[i])) continue;
    if (listed == kFew) {
      ++more;
      continue;
    }
    ++listed;
    parts.push_back(varying_[i] + " = " + text_of(own));
  }
  if (more != 0) parts.push_back(fmt::format("{} more", more));
  if (listed == 0 && varying_.size() > kFew) parts.push_back("all else as most points have it");
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
  return text;
}

std::size_t SweepViews::reference() const {
  for (const ShownPoint& point : points_) {
    if (point.view == 0 && first(point).design == "baseline") return point.machine;
  }
  return points_.empty() ? 0 : points_.front().machine;
}

double SweepViews::speedup(const ShownPoint& point, std::size_t machine) const {
  for (const ShownPoint& other : points_) {
    if (other.view == point.view && other.machine == machine) return value(other, kTime) / value(point, kTime);
  }
  return kNoValue;
}

}  // namespace grtx::sim
