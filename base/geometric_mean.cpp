// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/geometric_mean.h"

#include <cmath>

namespace grtx {

double geometric_mean(const std::vector<double>& values) {
  if (values.size() == 1) return values.front();
  double logarithms = 0.0;
  for (const double value : values) logarithms += std::log(value);
  return std::exp(logarithms / static_cast<double>(values.size()));
}

}  // namespace grtx
