// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/search/main_effects.h"

#include <cassert>
#include <cmath>
#include <numeric>

#include "grtx/explore/sweep/axis.h"

namespace grtx::explore {
namespace {

constexpr unsigned kRounds = 200;  ///< of backfitting, i.e. Gauss-Seidel sweeps over the normal equations

}  // namespace

MainEffects main_effects(const SearchSpace& space, const std::vector<Choices>& designs,
                         const std::vector<double>& costs) {
  assert(designs.size() == costs.size());
  MainEffects effects;
  for (const SearchSpace::Dimension& dimension : space.dimensions) {
    effects.factors.emplace_back(dimension.choices, 0.0);  // logarithms until the last step
    effects.designs.emplace_back(dimension.choices, 0);
  }
  std::vector<double> logs;
  for (const double cost : costs) logs.push_back(std::log(cost));
  const auto count = static_cast<double>(logs.size());
  const double mean = logs.empty() ? 0.0 : std::accumulate(logs.begin(), logs.end(), 0.0) / count;
  for (const Choices& design : designs) {
    for (std::size_t p = 0; p < design.size(); ++p) ++effects.designs[p][design[p]];
  }
  std::vector<double> residuals;
  for (const double value : logs) residuals.push_back(value - mean);
  for (unsigned round = 0; round < kRounds; ++round) {
    for (std::size_t p = 0; p < space.dimensions.size(); ++p) {
      std::vector<double> sums(space.dimensions[p].choices, 0.0);
      for (std::size_t i = 0; i < designs.size(); ++i) sums[designs[i][p]] += residuals[i];
      for (std::size_t c = 0; c < sums.size(); ++c) {
        if (effects.designs[p][c] == 0) continue;
        sums[c] /= static_cast<double>(effects.designs[p][c]);
        effects.factors[p][c] += sums[c];
      }
      for (std::size_t i = 0; i < designs.size(); ++i) residuals[i] -= sums[designs[i][p]];
    }
  }
  double total = 0.0, left = 0.0;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    total += (logs[i] - mean) * (logs[i] - mean);
    left += residuals[i] * residuals[i];
  }
  effects.explained = total > 0.0 ? nine_digits(1.0 - left / total) : 0.0;
  for (std::vector<double>& of_choices : effects.factors) {
    for (double& factor : of_choices) factor = nine_digits(std::exp(factor));
  }
  return effects;
}

}  // namespace grtx::explore
