// SPDX-License-Identifier: Apache-2.0
// Layout quantised: which Gaussians fit leaves of 32 B, and the grid of their means. The others get wide leaves.
// The rule and its figures: docs/model/node-image.md.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/frontend/gaussian/quantised_gaussian.h"
#include "grtx/frontend/scene/scene.h"

namespace grtx::frontend {

struct LeafWidths {
  /// A mean may be off by half a step: a step must be at most this share of a Gaussian's middle standard deviation.
  static constexpr double kTolerance = 1.0 / 8;
  /// The grid of all means stays unless it is too coarse for more than this share of the Gaussians.
  static constexpr double kMostCoarse = 1.0 / 8;

  MeanGrid grid;            ///< of all means, or of those with narrow leaves if other means would make it too coarse
  std::vector<bool> wide;   ///< [Gaussian]
  std::uint64_t count = 0;  ///< number of wide leaves

  static LeafWidths choose(const Scene& scene);
  void set_wide(std::size_t g) {
    count += wide[g] ? 0 : 1;
    wide[g] = true;
  }
};

}  // namespace grtx::frontend
