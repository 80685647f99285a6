#include "rtl_tlm/sampled/outline_correction.h"

#include <algorithm>
#include <cmath>

namespace grtx::tlm {

OutlineCorrection correct_outline(const std::vector<OutlineSample>& samples) {
  struct Row {
    std::uint64_t group;
    double weight, log_ratio;
  };
  std::vector<Row> rows;
  double sum = 0.0, squares = 0.0, weighted = 0.0;
  for (const OutlineSample& sample : samples) {
    for (std::size_t i = 0; i < sample.groups.size(); ++i) {
      const double weight = sample.weight[i];
      if (weight <= 0.0 || sample.end[i] <= 0.0 || sample.outline_end[i] <= 0.0) continue;
      rows.push_back({sample.groups[i], weight, std::log(sample.end[i] / sample.outline_end[i])});
      sum += weight;
      squares += weight * weight;
      weighted += weight * rows.back().log_ratio;
    }
  }
  OutlineCorrection correction;
  if (rows.empty()) return correction;
  correction.log_factor = weighted / sum;
  const double effective = sum * sum / squares;  // Kish: groups of equal work that would tell as much
  double residuals = 0.0;
  for (const Row& row : rows) {
    const double share = row.weight / sum;
    const double residual = correction.log_factor - row.log_ratio;
    residuals += share * residual * residual;
    correction.evidence.push_back({row.group, share * effective, residual, -share * residual});
  }
  correction.degrees_of_freedom = std::max(2.0, effective - 1.0);
  correction.residual = std::sqrt(residuals * (correction.degrees_of_freedom + 1.0) / correction.degrees_of_freedom);
  return correction;
}

}  // namespace grtx::tlm
