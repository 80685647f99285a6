// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/estimate/estimate.h"

#include <algorithm>
#include <cmath>

namespace grtx::sim {
namespace {

/// Cumulative distribution of Student's t for t >= 0. Substituting t = sqrt(degrees) tan(u) makes the integrand
/// cos(u)^(degrees - 1), which is smooth, so Simpson's rule with many steps is exact to many digits.
double student_cumulative(double t, double degrees) {
  const double end = std::atan(t / std::sqrt(degrees));
  constexpr int kSteps = 400;
  const auto integrand = [degrees](double u) { return std::pow(std::cos(u), degrees - 1.0); };
  const double h = end / kSteps;
  double sum = integrand(0.0) + integrand(end);
  for (int i = 1; i < kSteps; ++i) sum += (i % 2 == 1 ? 4.0 : 2.0) * integrand(i * h);
  const double norm =
      std::exp(std::lgamma(0.5 * (degrees + 1.0)) - std::lgamma(0.5 * degrees)) / std::sqrt(3.14159265358979323846);
  return 0.5 + norm * sum * h / 3.0;
}

/// A variance and its degrees of freedom.
struct Spread {
  double variance = 0.0, degrees = 1e9;
};

ConfidenceInterval interval(double log_value, const Spread& spread) {
  const double half_width = spread.variance > 0.0
                                ? student_quantile(0.5 + 0.5 * kConfidence, spread.degrees) * std::sqrt(spread.variance)
                                : 0.0;
  ConfidenceInterval result;
  result.value = std::exp(log_value);
  result.deviation = std::sqrt(spread.variance);
  result.low = std::exp(log_value - half_width);
  result.high = std::exp(log_value + half_width);
  result.half_width = std::expm1(half_width);
  return result;
}

/// Most of what a window takes beyond its costs changes slowly along the frame; strata take that in. So the variance is
/// that of the differences between neighbours (Wolter, Introduction to Variance Estimation, chapter 8), which has two
/// thirds of the degrees of freedom.
Spread spread_of(const CycleEstimate& e) {
  if (e.whole) return {};
  double squares = 0.0;
  for (std::size_t i = 1; i < e.evidence.size(); ++i) {
    const double step = e.evidence[i].influence - e.evidence[i - 1].influence;
    squares += step * step;
  }
  const double windows = static_cast<double>(e.evidence.size()), pairs = std::max(1.0, windows - 1.0);
  return {windows / (2.0 * pairs) * squares + e.drift * e.drift, std::max(2.0, 2.0 / 3.0 * pairs)};
}

bool same_windows(const CycleEstimate& a, const CycleEstimate& b) {
  return std::ranges::equal(a.evidence, b.evidence, {}, &GroupEvidence::group, &GroupEvidence::group);
}

}  // namespace

double student_quantile(double p, double degrees) {
  if (p < 0.5) return -student_quantile(1.0 - p, degrees);
  double low = 0.0, high = 1.0;
  while (student_cumulative(high, degrees) < p && high < 1e9) high *= 2.0;
  for (int i = 0; i < 80; ++i) {
    const double middle = 0.5 * (low + high);
    (student_cumulative(middle, degrees) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

ConfidenceInterval cycles_interval(const CycleEstimate& e) { return interval(e.log_cycles, spread_of(e)); }

ConfidenceInterval ratio_interval(const CycleEstimate& base, const CycleEstimate& other) {
  CycleEstimate ratio = base;
  ratio.log_cycles -= other.log_cycles;
  if (!same_windows(base, other)) {
    const Spread a = spread_of(base), b = spread_of(other);
    return interval(ratio.log_cycles, {a.variance + b.variance, std::min(a.degrees, b.degrees)});
  }
  ratio.drift -= other.drift;
  for (std::size_t i = 0; i < ratio.evidence.size(); ++i) ratio.evidence[i].influence -= other.evidence[i].influence;
  return cycles_interval(ratio);
}

nlohmann::ordered_json to_json(const CycleEstimate& estimate) {
  nlohmann::ordered_json json;
  json["log_cycles"] = estimate.log_cycles;
  json["whole"] = estimate.whole;
  json["drift"] = estimate.drift;
  json["evidence"] = nlohmann::ordered_json::array();
  for (const GroupEvidence& e : estimate.evidence) {
    json["evidence"].push_back({e.group, e.residual, e.influence});
  }
  return json;
}

CycleEstimate estimate_from_json(const nlohmann::ordered_json& json) {
  CycleEstimate estimate;
  estimate.log_cycles = json.at("log_cycles").get<double>();
  estimate.whole = json.at("whole").get<bool>();
  estimate.drift = json.at("drift").get<double>();
  for (const auto& e : json.at("evidence")) {
    estimate.evidence.push_back({e.at(0).get<std::uint64_t>(), e.at(1).get<double>(), e.at(2).get<double>()});
  }
  return estimate;
}

}  // namespace grtx::sim
