// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/estimate/estimate.h"

#include <algorithm>
#include <cmath>
#include <map>

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

double log_half_width(double variance, double degrees) {
  return variance > 0.0 ? student_quantile(0.5 + 0.5 * kConfidence, degrees) * std::sqrt(variance) : 0.0;
}

ConfidenceInterval interval(double log_value, double variance, double half_width) {
  ConfidenceInterval result;
  result.value = std::exp(log_value);
  result.deviation = std::sqrt(variance);
  result.low = std::exp(log_value - half_width);
  result.high = std::exp(log_value + half_width);
  result.half_width = std::expm1(half_width);
  return result;
}

/// Sampling variance of the logarithm: sandwich estimator with its correction for few subsamples.
double variance_of(const std::vector<GroupEvidence>& evidence, double degrees) {
  double influence = 0.0;
  for (const GroupEvidence& e : evidence) influence += e.influence * e.influence;
  return (degrees + 2.0) / degrees * influence;
}

/// Sampling variance and squared bias have different degrees of freedom, which are combined after Welch and
/// Satterthwaite. A small sampling variance can lower Student's quantile faster than it raises the deviation, so no
/// interval is narrower than that of the bias alone.
ConfidenceInterval interval_with_bias(double log_value, double variance, double degrees, double bias,
                                      double bias_degrees) {
  const double squared_bias = bias * bias, all = variance + squared_bias;
  if (all == 0.0) return interval(log_value, 0.0, 0.0);
  const double combined_degrees =
      all * all / (variance * variance / degrees + squared_bias * squared_bias / bias_degrees);
  return interval(log_value, all,
                  std::max(log_half_width(all, combined_degrees), log_half_width(squared_bias, bias_degrees)));
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

ConfidenceInterval cycles_interval(const CycleEstimate& e) {
  if (e.whole) return interval(e.log_cycles, 0.0, 0.0);
  return interval_with_bias(e.log_cycles, variance_of(e.evidence, e.degrees_of_freedom), e.degrees_of_freedom,
                            e.bias.cycles, e.bias.degrees);
}

ConfidenceInterval ratio_interval(const CycleEstimate& base, const CycleEstimate& other) {
  const double log_ratio = base.log_cycles - other.log_cycles;
  if (base.whole && other.whole) return interval(log_ratio, 0.0, 0.0);
  std::map<std::uint64_t, GroupEvidence> differences;
  for (const GroupEvidence& e : base.evidence) differences[e.group].influence += e.influence;
  for (const GroupEvidence& e : other.evidence) differences[e.group].influence -= e.influence;
  std::vector<GroupEvidence> evidence;
  for (const auto& [group, e] : differences) evidence.push_back(e);
  double degrees = 1e9;
  for (const CycleEstimate* e : {&base, &other}) {
    if (!e->whole) degrees = std::min(degrees, e->degrees_of_freedom);
  }
  // A design that was simulated completely has no bias: only the other's counts.
  const double bias = base.whole ? other.bias.cycles : other.whole ? base.bias.cycles : base.bias.ratio;
  return interval_with_bias(log_ratio, variance_of(evidence, degrees), degrees, bias,
                            base.whole ? other.bias.degrees : base.bias.degrees);
}

nlohmann::ordered_json to_json(const CycleEstimate& estimate) {
  nlohmann::ordered_json json;
  json["log_cycles"] = estimate.log_cycles;
  json["whole"] = estimate.whole;
  json["degrees_of_freedom"] = estimate.degrees_of_freedom;
  json["bias"] = {estimate.bias.cycles, estimate.bias.ratio, estimate.bias.degrees};
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
  estimate.degrees_of_freedom = json.at("degrees_of_freedom").get<double>();
  estimate.bias = {json.at("bias").at(0).get<double>(), json.at("bias").at(1).get<double>(),
                   json.at("bias").at(2).get<double>()};
  for (const auto& e : json.at("evidence")) {
    estimate.evidence.push_back({e.at(0).get<std::uint64_t>(), e.at(1).get<double>(), e.at(2).get<double>()});
  }
  return estimate;
}

}  // namespace grtx::sim
