// SPDX-License-Identifier: Apache-2.0
// Shape of a Gaussian: its response over the distance, and where it ends.
#pragma once

namespace grtx::frontend {

/// The response at d standard deviations is exp(-4.5 (d / 3)^degree), as in 3DGRT's kernels: degree 2 is the normal
/// distribution, for which plain 3DGS files are trained; degree 4 has a flatter top and a steeper edge, and covers more
/// where the opacity is low.
struct Kernel {
  // NOLINTNEXTLINE(google-explicit-constructor): most callers choose the radius only
  constexpr Kernel(bool adaptive_radius = true, unsigned of_degree = 2)
      : adaptive(adaptive_radius), degree(of_degree) {}
  bool adaptive;    ///< the Gaussian ends where opacity * response falls to 0.0113, else at 3 standard deviations
  unsigned degree;  ///< 2 or 4
  bool operator==(const Kernel&) const = default;
};

}  // namespace grtx::frontend
