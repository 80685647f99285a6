// SPDX-License-Identifier: Apache-2.0
// Agreement of two simulation modes on the points run in both: shows how far a screening can be trusted.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "grtx/report/page/sweep_results.h"

namespace grtx::report {

/// Kendall's tau-b of two rankings of the same things (Kendall, Biometrika 33, 1945): 1 for the same order, -1 for the
/// reverse; pairs equal in one of them count half. NaN if all values of one are equal. Values must be finite.
double kendall_tau(const std::vector<double>& a, const std::vector<double>& b);

/// Agreement of two modes on one scene.
struct ModeAgreement {
  std::string scene;
  std::string mode, against;  ///< the mode whose point comes first, and the other
  std::size_t points = 0;     ///< number of points done in both, with the same design and coordinates
  double mean_ratio = 1.0;    ///< geometric mean of time(mode) / time(against)
  double least_ratio = 1.0, largest_ratio = 1.0;
  double tau = 0.0;  ///< Kendall's tau of the times; NaN if all times of one mode are equal
};
/// One entry for each scene and pair of modes with at least two common points.
std::vector<ModeAgreement> mode_agreements(const SweepResults& sweep);

}  // namespace grtx::report
