// SPDX-License-Identifier: Apache-2.0
// Effect of each parameter on a cost: an additive model of the cost's logarithm, fitted by least squares. A search
// samples its space unevenly, so plain means over the designs with a value would confound the parameters.
#pragma once

#include <vector>

#include "grtx/explore/search/nsga2.h"

namespace grtx::explore {

struct MainEffects {
  /// [parameter][choice]: factor on the cost, relative to the geometric mean over all designs; 1 if no design has the
  /// choice.
  std::vector<std::vector<double>> factors;
  std::vector<std::vector<std::size_t>> designs;  ///< [parameter][choice]: number of designs
  double explained = 0.0;                         ///< coefficient of determination of the logarithms, 0 to 1
};

/// costs: one per design, above 0.
MainEffects main_effects(const SearchSpace& space, const std::vector<Choices>& designs,
                         const std::vector<double>& costs);

}  // namespace grtx::explore
