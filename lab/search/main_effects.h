// What each parameter contributes: an additive model of the logarithms of a cost, by least squares. A search samples
// its space unevenly, so means over the designs with a value would mix the parameters up.
#pragma once

#include <vector>

#include "grtx/lab/search/nsga2.h"

namespace grtx::sim {

struct MainEffects {
  /// By parameter and choice: the factor on the cost, relative to the geometric mean over the designs; 1 where no
  /// design has the choice.
  std::vector<std::vector<double>> factors;
  std::vector<std::vector<std::size_t>> designs;  ///< how many have the choice
  double explained = 0.0;  ///< share of the variance of the logarithms that the model explains, 0 to 1
};

/// costs: above 0, one a design.
MainEffects main_effects(const SearchSpace& space, const std::vector<Choices>& designs,
                         const std::vector<double>& costs);

}  // namespace grtx::sim
