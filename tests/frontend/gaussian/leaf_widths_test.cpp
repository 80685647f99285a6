// SPDX-License-Identifier: Apache-2.0
// Which Gaussians get wide leaves: none in scenes without outliers, whose grid is that of all means; else as few as
// possible.
#include "grtx/frontend/gaussian/leaf_widths.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace grtx::frontend {
namespace {

/// In a cube of 10 units, with discs of 0.01 to 0.1.
Scene cube(std::size_t count) {
  std::mt19937 engine(5);
  const auto uniform = [&](float low, float high) { return std::uniform_real_distribution<float>(low, high)(engine); };
  Scene scene;
  for (std::size_t g = 0; g < count; ++g) {
    scene.mean.emplace_back(uniform(0, 10), uniform(0, 10), uniform(0, 10));
    scene.scale.emplace_back(uniform(0.01f, 0.1f), 1e-5f, uniform(0.01f, 0.1f));
  }
  return scene;
}

void expect_grid(const MeanGrid& grid, const MeanGrid& expected) {
  EXPECT_EQ(grid.origin, expected.origin);
  EXPECT_EQ(grid.step, expected.step);
}

TEST(LeafWidths, NoneAreWideWithoutOutliers) {
  Scene scene = cube(2000);
  for (std::size_t g = 0; g < 200; ++g) scene.scale[g] = glm::vec3(1e-6f);  // dust is no outlier
  scene.mean[0] = {1000.0f, 0.0f, 0.0f};  // far, but not so far that the others lose by it
  const LeafWidths widths = LeafWidths::choose(scene);
  EXPECT_EQ(widths.count, 0u);
  expect_grid(widths.grid, MeanGrid::covering(scene.mean));
}

TEST(LeafWidths, OutliersLeaveTheGridOfTheOthers) {
  const Scene without = cube(2000);
  for (const float distance : {1e5f, 1e6f, 1e12f, 3e38f}) {
    SCOPED_TRACE(distance);
    Scene scene = without;
    for (const float x : {distance, -distance, 0.0f}) {
      scene.mean.emplace_back(x, 0.0f, x == 0.0f ? -distance : 0.0f);
      scene.scale.emplace_back(0.05f);
    }
    const LeafWidths widths = LeafWidths::choose(scene);
    EXPECT_EQ(widths.count, 3u);
    for (std::size_t g = 0; g < scene.size(); ++g) EXPECT_EQ(widths.wide[g], g >= without.size());
    expect_grid(widths.grid, MeanGrid::covering(without.mean));
  }
}

// Where no grid serves, all leaves are wide: the picture is right, and the bytes say what it takes.
TEST(LeafWidths, GaussiansThatNoGridServesAreAllWide) {
  Scene scene = cube(2000);
  for (glm::vec3& mean : scene.mean) mean *= 1e7f;
  const LeafWidths widths = LeafWidths::choose(scene);
  EXPECT_GE(widths.count, scene.size() * 9 / 10);
}

TEST(LeafWidths, OfNoneAndOfOne) {
  EXPECT_EQ(LeafWidths::choose(Scene()).count, 0u);
  EXPECT_EQ(LeafWidths::choose(cube(1)).count, 0u);
}

}  // namespace
}  // namespace grtx::frontend
