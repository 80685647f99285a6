// SPDX-License-Identifier: Apache-2.0
// The mean of ratios.
#pragma once

#include <vector>

namespace grtx {

/// Geometric mean of values above 0. One value is its own mean to the last bit; that of none is NaN.
double geometric_mean(const std::vector<double>& values);

}  // namespace grtx
