// SPDX-License-Identifier: Apache-2.0
// Cycles of a run as estimated from a sample of it, with confidence intervals for them and for the ratio of two runs.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

namespace grtx::sim {

inline constexpr double kConfidence = 0.95;
/// Error that remains however large the sample is, as standard deviation of the logarithm: of the cycles, and of the
/// ratio of two designs' cycles.
struct ModelBias {
  double cycles = 0.0, ratio = 0.0;
  double degrees = 4.0;  ///< of freedom: number of independent scenes that it was measured on, minus one
};

/// Contribution of one window to the estimate.
struct GroupEvidence {
  std::uint64_t group = 0;  ///< first group of the window
  double residual = 0.0;    ///< relative deviation from the expected value
  double influence = 0.0;   ///< on the logarithm of the cycles; the sum of squares estimates its variance
};

struct CycleEstimate {
  double log_cycles = 0.0;
  bool whole = false;  ///< everything was simulated: exact
  double degrees_of_freedom = 1.0;
  ModelBias bias;
  std::vector<GroupEvidence> evidence;
};

struct ConfidenceInterval {
  double value = 0.0, low = 0.0, high = 0.0;
  double deviation = 0.0;   ///< standard deviation of the logarithm, sampling error and bias
  double half_width = 0.0;  ///< max(value / low, high / value) - 1
};

/// 95 % interval of a statistic.
struct StatisticInterval {
  double low = 0.0, high = 0.0;
};

/// Quantile of Student's t distribution, 0 < p < 1, degrees >= 1.
double student_quantile(double p, double degrees);

ConfidenceInterval cycles_interval(const CycleEstimate& estimate);
/// Interval of cycles(base) / cycles(other). Subsamples of the same group are paired: errors that both have cancel.
ConfidenceInterval ratio_interval(const CycleEstimate& base, const CycleEstimate& other);

nlohmann::ordered_json to_json(const CycleEstimate& estimate);
CycleEstimate estimate_from_json(const nlohmann::ordered_json& json);

}  // namespace grtx::sim
