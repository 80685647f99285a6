#include "grtx/rtl_tlm/estimate/sampled/fast_correction.h"

#include <algorithm>
#include <cmath>

namespace grtx::sim {

FastCorrection correct_fast(const std::vector<FastSample>& samples) {
  struct Row {
    std::uint64_t group;
    double weight, end, fast_end;
  };
  std::vector<Row> rows;
  double sum = 0.0, squares = 0.0, ends = 0.0, fast_ends = 0.0;
  for (const FastSample& sample : samples) {
    for (std::size_t i = 0; i < sample.groups.size(); ++i) {
      const double weight = sample.weight[i];
      if (weight <= 0.0) continue;
      rows.push_back({sample.groups[i], weight, sample.end[i], sample.fast_end[i]});
      sum += weight;
      squares += weight * weight;
      ends += weight * sample.end[i];
      fast_ends += weight * sample.fast_end[i];
    }
  }
  FastCorrection correction;
  if (!(ends > 0.0 && fast_ends > 0.0)) return correction;
  // A ratio of sums: an early end that is off by the same cycles as a late one counts no more than that.
  const double factor = ends / fast_ends, mean = ends / sum;
  correction.log_factor = std::log(factor);
  const double effective = sum * sum / squares;  // Kish: groups of equal work that would tell as much
  double residuals = 0.0;
  for (const Row& row : rows) {
    const double share = row.weight / sum;
    const double residual = (factor * row.fast_end - row.end) / mean;
    residuals += share * residual * residual;
    correction.evidence.push_back({row.group, 0.0, residual, -share * residual});
  }
  correction.degrees_of_freedom = std::max(2.0, effective - 1.0);
  // How far the model is off in a design is known beforehand, about: a correction that the samples do not know better
  // than that counts for less.
  double variance = 0.0;
  for (const GroupEvidence& e : correction.evidence) variance += e.influence * e.influence;
  variance *= (correction.degrees_of_freedom + 1.0) / correction.degrees_of_freedom;
  constexpr double kSquare = kFastSpread * kFastSpread;
  const double trust = kSquare / (kSquare + variance);
  correction.log_factor *= trust;
  for (GroupEvidence& e : correction.evidence) e.influence *= trust;
  correction.prior_variance = (1.0 - trust) * (1.0 - trust) * kSquare;
  correction.residual = std::sqrt(residuals * (correction.degrees_of_freedom + 1.0) / correction.degrees_of_freedom);
  return correction;
}

}  // namespace grtx::sim
