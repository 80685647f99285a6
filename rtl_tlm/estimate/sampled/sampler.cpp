#include "grtx/rtl_tlm/estimate/sampled/sampler.h"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

#include "grtx/rtl_tlm/estimate/sampled/lots.h"

namespace grtx::sim {
std::vector<std::vector<std::uint64_t>> deal_classes(const std::vector<GroupWork>& groups, unsigned classes,
                                                     std::uint64_t seed) {
  std::vector<std::uint64_t> order(groups.size());
  std::iota(order.begin(), order.end(), std::uint64_t{0});
  const auto rank = [&groups](std::uint64_t i) {
    return std::tuple(groups[i].kind, ~groups[i].processed, i);  // most processed first
  };
  std::sort(order.begin(), order.end(), [&rank](std::uint64_t a, std::uint64_t b) { return rank(a) < rank(b); });
  std::vector<std::vector<std::uint64_t>> dealt(classes);
  std::vector<unsigned> hands(classes);
  std::iota(hands.begin(), hands.end(), 0u);
  Lots lots(seed);
  for (std::size_t first = 0; first < order.size(); first += classes) {
    for (std::size_t i = classes; i > 1; --i) std::swap(hands[i - 1], hands[lots.below(i)]);
    for (std::size_t i = 0; i < classes && first + i < order.size(); ++i) dealt[hands[i]].push_back(order[first + i]);
  }
  for (std::vector<std::uint64_t>& one : dealt) std::sort(one.begin(), one.end());
  return dealt;
}

}  // namespace grtx::sim
