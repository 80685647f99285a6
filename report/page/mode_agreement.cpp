// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/mode_agreement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "grtx/base/geometric_mean.h"
#include "grtx/report/page/sweep_views.h"

namespace grtx::report {
namespace {

/// Times of points that differ only in the mode.
using Times = std::map<std::string, double>;

struct SceneModes {
  std::string scene;
  std::vector<std::string> modes;  ///< in order of appearance
  std::map<std::string, Times> times;
};

std::vector<SceneModes> times_of(const SweepResults& sweep) {
  std::vector<SceneModes> scenes;
  for (const ReportedPoint& p : sweep.points) {
    const double time = p.value("gpu.time_us");
    if (!p.done() || !std::isfinite(time) || time <= 0.0) continue;
    auto scene = std::find_if(scenes.begin(), scenes.end(), [&](const SceneModes& s) { return s.scene == p.scene; });
    if (scene == scenes.end()) scene = scenes.insert(scenes.end(), {p.scene, {}, {}});
    if (!scene->times.contains(p.mode)) scene->modes.push_back(p.mode);
    scene->times[p.mode][but_for_mode(sweep, p)] = time;
  }
  return scenes;
}

int sign(double difference) { return (difference > 0.0) - (difference < 0.0); }

ModeAgreement compare(const SceneModes& scene, const std::string& mode, const std::string& against) {
  ModeAgreement agreement{scene.scene, mode, against};
  std::vector<double> a, b;
  for (const auto& [point, time] : scene.times.at(mode)) {
    const auto other = scene.times.at(against).find(point);
    if (other == scene.times.at(against).end()) continue;
    a.push_back(time);
    b.push_back(other->second);
  }
  agreement.points = a.size();
  if (a.empty()) return agreement;
  std::vector<double> ratios;
  for (std::size_t i = 0; i < a.size(); ++i) ratios.push_back(a[i] / b[i]);
  agreement.mean_ratio = geometric_mean(ratios);
  agreement.least_ratio = std::ranges::min(ratios);
  agreement.largest_ratio = std::ranges::max(ratios);
  agreement.tau = kendall_tau(a, b);
  return agreement;
}

}  // namespace

double kendall_tau(const std::vector<double>& a, const std::vector<double>& b) {
  double in_order = 0.0, ranked_by_a = 0.0, ranked_by_b = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const int first = sign(a[i] - a[j]), second = sign(b[i] - b[j]);
      in_order += first * second;
      ranked_by_a += first * first;
      ranked_by_b += second * second;
    }
  }
  if (ranked_by_a == 0.0 || ranked_by_b == 0.0) return std::numeric_limits<double>::quiet_NaN();
  return in_order / std::sqrt(ranked_by_a * ranked_by_b);
}

std::vector<ModeAgreement> mode_agreements(const SweepResults& sweep) {
  std::vector<ModeAgreement> list;
  for (const SceneModes& scene : times_of(sweep)) {
    for (std::size_t i = 0; i < scene.modes.size(); ++i) {
      for (std::size_t j = i + 1; j < scene.modes.size(); ++j) {
        const ModeAgreement agreement = compare(scene, scene.modes[i], scene.modes[j]);
        if (agreement.points >= 2) list.push_back(agreement);
      }
    }
  }
  return list;
}

}  // namespace grtx::report
