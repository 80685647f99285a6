// The estimate of a run's cycles from a sample of it, and what it says about ratios of two runs.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

namespace grtx::sim {

inline constexpr double kConfidence = 0.95;
/// What a sample leaves over however large it is, as standard deviations on the logarithm: of cycles and of a ratio of
/// two designs.
struct ModelBias {
  double cycles = 0.0, ratio = 0.0;
  double degrees = 4.0;  ///< of freedom: number of independent scenes that it was measured on, minus one
};

/// What one subsample contributed: a window, or an SM.
struct GroupEvidence {
  std::uint64_t group = 0;  ///< the window's first, or the SM
  double residual = 0.0;    ///< what it took beyond what was expected of it, over that
  double influence = 0.0;   ///< on the logarithm of the estimate: its sum of squares estimates the variance
};

struct SampledEstimate {
  double log_cycles = 0.0;
  bool whole = false;  ///< everything was simulated: exact
  double degrees_of_freedom = 1.0;
  ModelBias bias;
  std::vector<GroupEvidence> evidence;
};

struct ConfidenceInterval {
  double value = 0.0, low = 0.0, high = 0.0;
  double deviation = 0.0;   ///< of the logarithm, all terms
  double half_width = 0.0;  ///< relative: the larger of value / low and high / value, less one
};

/// Quantile of Student's t distribution, 0 < p < 1, degrees >= 1.
double student_quantile(double p, double degrees);

ConfidenceInterval cycles_interval(const SampledEstimate& estimate);
/// Interval of cycles(base) / cycles(other). Subsamples that both have are pairs: what they have in common cancels.
ConfidenceInterval ratio_interval(const SampledEstimate& base, const SampledEstimate& other);

nlohmann::ordered_json to_json(const SampledEstimate& estimate);
SampledEstimate estimate_from_json(const nlohmann::ordered_json& json);

}  // namespace grtx::sim
