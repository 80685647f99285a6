// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/gaussian/leaf_widths.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace grtx::frontend {
namespace {

double largest_step(const MeanGrid& grid) {
  return static_cast<double>(std::max({grid.step.x, grid.step.y, grid.step.z}));
}

// The middle one, because a mean that moves along the least axis of a disc moves what is seen by nothing.
double middle(const glm::vec3& scale) {
  return static_cast<double>(std::max(std::min(scale.x, scale.y), std::min(std::max(scale.x, scale.y), scale.z)));
}

bool too_coarse(double step, const glm::vec3& scale) { return step > LeafWidths::kTolerance * middle(scale); }

struct Window {
  float lower = 0.0f, upper = 0.0f;
  std::size_t means = 0;  ///< between the two, both included
};

/// The window of this length with the most means. sorted: ascending.
Window fullest_window(const std::vector<float>& sorted, double length) {
  Window best;
  for (std::size_t first = 0, end = 0; end < sorted.size(); ++first) {
    while (end < sorted.size() && static_cast<double>(sorted[end]) - static_cast<double>(sorted[first]) <= length)
      ++end;
    if (end - first > best.means) best = {sorted[first], sorted[end - 1], end - first};
  }
  return best;
}

using Windows = std::array<Window, 3>;

bool holds(const Windows& windows, const glm::vec3& mean) {
  for (int axis = 0; axis < 3; ++axis) {
    const Window& window = windows[static_cast<std::size_t>(axis)];
    if (mean[axis] < window.lower || mean[axis] > window.upper) return false;
  }
  return true;
}

/// The Gaussians that need wide leaves beside a grid in these windows.
std::uint64_t count_wide(const Scene& scene, const Windows& windows, double step) {
  std::uint64_t count = 0;
  for (std::size_t g = 0; g < scene.size(); ++g) {
    count += holds(windows, scene.mean[g]) && !too_coarse(step, scene.scale[g]) ? 0 : 1;
  }
  return count;
}

/// Of the grids that are finer by powers of two, the one with the fewest wide leaves.
void choose_finer_grid(const Scene& scene, LeafWidths& widths) {
  std::array<std::vector<float>, 3> sorted;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<float>& of_axis = sorted[static_cast<std::size_t>(axis)];
    for (const glm::vec3& mean : scene.mean) of_axis.push_back(mean[axis]);
    std::sort(of_axis.begin(), of_axis.end());
  }
  Windows chosen;
  double chosen_step = 0.0;
  std::uint64_t fewest = std::numeric_limits<std::uint64_t>::max();
  for (double step = largest_step(widths.grid); step >= MeanGrid::kLeastStep; step /= 2) {
    Windows windows;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      windows[axis] = fullest_window(sorted[axis], step * MeanGrid::kMostCode);
    }
    // A finer grid leaves out still more.
    const std::size_t held = std::min({windows[0].means, windows[1].means, windows[2].means});
    if (scene.size() - held >= fewest) break;
    const std::uint64_t wide = count_wide(scene, windows, step);
    if (wide >= fewest) continue;
    fewest = wide;
    chosen = windows;
    chosen_step = step;
  }
  std::vector<glm::vec3> narrow;
  for (std::size_t g = 0; g < scene.size(); ++g) {
    if (holds(chosen, scene.mean[g]) && !too_coarse(chosen_step, scene.scale[g])) {
      narrow.push_back(scene.mean[g]);
    } else {
      widths.set_wide(g);
    }
  }
  widths.grid = MeanGrid::covering(narrow);
}

}  // namespace

LeafWidths LeafWidths::choose(const Scene& scene) {
  LeafWidths widths;
  widths.grid = MeanGrid::covering(scene.mean);
  widths.wide.resize(scene.size());
  const double step = largest_step(widths.grid);
  const auto coarse = std::count_if(scene.scale.begin(), scene.scale.end(),
                                    [&](const glm::vec3& scale) { return too_coarse(step, scale); });
  if (static_cast<double>(coarse) > kMostCoarse * static_cast<double>(scene.size())) choose_finer_grid(scene, widths);
  return widths;
}

}  // namespace grtx::frontend
