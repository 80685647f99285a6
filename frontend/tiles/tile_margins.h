// SPDX-License-Identifier: Apache-2.0
// Margins of tile tracing's conservative tests for fp32 rounding, so that no hit is rejected. Reasons:
// docs/model/tiles.md.
#pragma once

#include <cmath>
#include <limits>

#include "grtx/frontend/tiles/tile_rays.h"

namespace grtx::frontend {

/// Bound on fp32 rounding in the outline test and the hit function, relative to the sizes involved: 64 units of 2^-24.
/// docs/model/tiles.md counts about 30.
inline constexpr float kOutlineSlack = 1.0f / (1 << 18);

/// Bound on fp32 rounding of a box's place on the grid, relative to its size there.
inline constexpr float kGridSlack = 1.0f / (1 << 14);

/// Slack for |w|^2 - |l|^2 with w = a x l (l: a direction, a: the origin's place, both in the unit frame), from the
/// products of the columns axis, right, down.
inline float outline_slack(const TileRays& tile, float norm, const float* mean, const float* a, const float* ww,
                           const float* ll) {
  const float size_w = ww[0] + tile.extent2 * (ww[1] + ww[2]);
  const float size_l = ll[0] + tile.extent2 * (ll[1] + ll[2]);
  if (!(size_l > 1e-30f && size_w < 1e30f)) return std::numeric_limits<float>::infinity();
  // Sums of absolute values instead of lengths: never smaller.
  const float distance = std::fabs(mean[0]) + std::fabs(mean[1]) + std::fabs(mean[2]);
  const float place = std::fabs(a[0]) + std::fabs(a[1]) + std::fabs(a[2]) + 1.0f;
  const float l = std::sqrt(3.0f * size_l);
  const float error = kOutlineSlack * norm * (distance * l + place);
  return 2.0f * l * error + error * error + kOutlineSlack * (size_w + size_l);
}

}  // namespace grtx::frontend
