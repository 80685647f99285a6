// SPDX-License-Identifier: Apache-2.0
// Cycles of a run as estimated from a sample of it, with confidence intervals for them and for the ratio of two runs.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

namespace grtx::sim {

inline constexpr double kConfidence = 0.95;
/// Contribution of one window to the estimate.
struct GroupEvidence {
  std::uint64_t group = 0;  ///< first group of the window
  double residual = 0.0;    ///< relative deviation from the expected value
  double influence = 0.0;   ///< on the logarithm of the cycles
};

struct CycleEstimate {
  double log_cycles = 0.0;
  bool whole = false;  ///< everything was simulated: exact
  /// The time that first halves of the windows took more than second ones, over the cycles: state that has not settled.
  /// A window is off by no more than it still changes by.
  double drift = 0.0;
  std::vector<GroupEvidence> evidence;  ///< in the order of the trace
};

struct ConfidenceInterval {
  double value = 0.0, low = 0.0, high = 0.0;
  double deviation = 0.0;   ///< standard deviation of the logarithm, sampling error and drift
  double half_width = 0.0;  ///< max(value / low, high / value) - 1
};

/// 95 % interval of a statistic.
struct StatisticInterval {
  double low = 0.0, high = 0.0;
};

/// Quantile of Student's t distribution, 0 < p < 1, degrees >= 1.
double student_quantile(double p, double degrees);

ConfidenceInterval cycles_interval(const CycleEstimate& estimate);
/// Interval of cycles(base) / cycles(other). If both have the same windows, errors that both have cancel.
ConfidenceInterval ratio_interval(const CycleEstimate& base, const CycleEstimate& other);

nlohmann::ordered_json to_json(const CycleEstimate& estimate);
CycleEstimate estimate_from_json(const nlohmann::ordered_json& json);

}  // namespace grtx::sim
