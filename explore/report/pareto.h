// The front of designs that no other beats in both of two costs.
#pragma once

#include <cstddef>
#include <vector>

namespace grtx::sim {

struct Costs {
  double first = 0.0;  ///< less is better, in both
  double second = 0.0;
};

/// Which points lie on the front: no other is better in one cost and at least as good in the other. Equal points are
/// all on it; a point with a cost that is not finite never is.
std::vector<bool> pareto_front(const std::vector<Costs>& points);

}  // namespace grtx::sim
