#include "grtx/explore/report/pareto.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace grtx::sim {

std::vector<bool> pareto_front(const std::vector<Costs>& points) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (std::isfinite(points[i].first) && std::isfinite(points[i].second)) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    if (points[a].first != points[b].first) return points[a].first < points[b].first;
    return points[a].second < points[b].second;
  });
  // In order of the first cost, a point is on the front when its second is below all before; its equals are too.
  std::vector<bool> front(points.size(), false);
  const Costs* last = nullptr;
  for (const std::size_t i : order) {
    const bool equal = last != nullptr && last->first == points[i].first && last->second == points[i].second;
    if (last != nullptr && !equal && points[i].second >= last->second) continue;
    front[i] = true;
    last = &points[i];
  }
  return front;
}

}  // namespace grtx::sim
