// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/dominance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace grtx::explore {

bool dominates(const std::vector<double>& a, const std::vector<double>& b) {
  bool less = false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!(a[i] <= b[i])) return false;
    less = less || a[i] < b[i];
  }
  return less;
}

std::vector<bool> non_dominated(const std::vector<std::vector<double>>& costs) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < costs.size(); ++i) {
    const auto finite = [](double cost) { return std::isfinite(cost); };
    if (!costs[i].empty() && std::all_of(costs[i].begin(), costs[i].end(), finite)) order.push_back(i);
  }
  // In lexicographic order a dominating design comes first, and any dominated design is dominated by one on the front.
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return costs[a] < costs[b]; });
  std::vector<bool> on(costs.size(), false);
  std::vector<std::size_t> front;
  for (const std::size_t i : order) {
    const auto beats = [&](std::size_t other) { return dominates(costs[other], costs[i]); };
    if (std::any_of(front.begin(), front.end(), beats)) continue;
    on[i] = true;
    front.push_back(i);
  }
  return on;
}

}  // namespace grtx::explore
