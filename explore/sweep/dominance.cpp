#include "grtx/explore/sweep/dominance.h"

#include <algorithm>

namespace grtx::sim {

bool dominates(const std::vector<double>& a, const std::vector<double>& b) {
  bool less = false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!(a[i] <= b[i])) return false;
    less = less || a[i] < b[i];
  }
  return less;
}

std::vector<bool> non_dominated(const std::vector<std::vector<double>>& costs) {
  std::vector<bool> front;
  for (const std::vector<double>& mine : costs) {
    front.push_back(!mine.empty() && std::none_of(costs.begin(), costs.end(), [&](const std::vector<double>& other) {
      return !other.empty() && dominates(other, mine);
    }));
  }
  return front;
}

}  // namespace grtx::sim
