// How far two modes of simulation agree on the points that both have run: what a screening may be trusted with.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "grtx/view/report/sweep_results.h"

namespace grtx::sim {

/// Kendall's tau-b of two rankings of the same things (Kendall, Biometrika 33, 1945): 1 for the same order, -1 for the
/// reverse; pairs equal in one of them count half. NaN when one ranks nothing. Values must be finite.
double kendall_tau(const std::vector<double>& a, const std::vector<double>& b);

/// How far two modes agree on one scene.
struct ModeAgreement {
  std::string scene;
  std::string mode, against;  ///< in order of their first points
  std::size_t points = 0;     ///< done in both: same design and coordinates
  double mean_ratio = 1.0;    ///< geometric mean of the times, mode over against
  double least_ratio = 1.0, largest_ratio = 1.0;
  double tau = 0.0;  ///< of the times' rankings; NaN when one of the modes has all times equal
};
/// Each scene and pair of modes with at least two points in common.
std::vector<ModeAgreement> mode_agreements(const SweepResults& sweep);

}  // namespace grtx::sim
