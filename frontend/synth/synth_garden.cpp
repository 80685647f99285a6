// SPDX-License-Identifier: Apache-2.0
// The garden preset: a garden with a round table, seen while walking around it; detail falls with the distance.
// Units: metres; y points down.
#include <cmath>
#include <glm/geometric.hpp>

#include "grtx/frontend/numbers/portable_math.h"
#include "grtx/frontend/synth/synth_world.h"

namespace grtx::frontend {
namespace {

using V = glm::dvec3;
using P = SynthPattern;

/// The captured middle is fine, the rim coarse: ln d8 grows with the distance from the middle.
double detail_at(const V& at) { return 0.75 * portable_log((1.2 + glm::length(V(at.x, 0, at.z))) / 5.0); }

void lawn(SynthLayout& layout) {
  constexpr int kCells = 12;
  constexpr double kSize = 2.0;
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      const V corner((i - kCells / 2) * kSize, 0, (j - kCells / 2) * kSize);
      const V middle = corner + V(0.5 * kSize, 0, 0.5 * kSize);
      const bool paved = std::abs(middle.x) < 2.1 && std::abs(middle.z) < 2.1;
      const bool path = !paved && std::abs(middle.x) < 1.1 && middle.z < 0;
      if (paved || path) {
        layout.style({P::bricks, {0.60, 0.53, 0.46}, {0.40, 0.37, 0.33}, 0.28}, detail_at(middle) - 0.2);
        layout.ground(corner, {kSize, 0, 0}, {0, 0, kSize}, 1.0);
        continue;
      }
      layout.style({P::mottled, {0.20, 0.33, 0.10}, {0.42, 0.47, 0.20}, 0.35}, detail_at(middle));
      layout.ground(corner, {kSize, 0, 0}, {0, 0, kSize}, 1.0);
      SynthPatch& blades =
          layout.style({P::mottled, {0.22, 0.40, 0.10}, {0.50, 0.60, 0.22}, 0.25}, detail_at(middle) + 0.15);
      blades.grain = {0, -1, 0};
      layout.leaves(middle - V(0, 0.06, 0), {1.1, 0.09, 1.1}, 0.06);
    }
  }
}

void table(SynthLayout& layout) {
  layout.style({P::planks, {0.62, 0.47, 0.32}, {0.40, 0.28, 0.18}, 0.14}, -0.75);
  layout.ellipsoid({0, -0.75, 0}, {0.85, 0.04, 0.85});
  layout.cylinder({0, -0.02, 0}, {0, -0.74, 0}, 0.08);
  for (const double side : {-0.35, 0.35}) {
    layout.cylinder({side, 0, 0}, {0, -0.25, 0}, 0.04);
    layout.cylinder({0, 0, side}, {0, -0.25, 0}, 0.04);
  }
  layout.style({P::stripes, {0.20, 0.35, 0.62}, {0.88, 0.88, 0.84}, 0.07}, -0.95);  // vase with flowers
  layout.ellipsoid({0.05, -0.98, 0.02}, {0.14, 0.2, 0.14});
  layout.cylinder({0.05, -1.12, 0.02}, {0.05, -1.24, 0.02}, 0.06);
  layout.style({P::mottled, {0.18, 0.38, 0.12}, {0.3, 0.5, 0.18}, 0.1}, -0.7);
  layout.leaves({0.05, -1.32, 0.02}, {0.2, 0.14, 0.2}, 0.05);
  layout.style({P::mottled, {0.88, 0.25, 0.30}, {0.98, 0.75, 0.25}, 0.1}, -0.85);
  layout.leaves({0.05, -1.47, 0.02}, {0.22, 0.12, 0.22}, 0.045);
  layout.style({P::mottled, {0.85, 0.6, 0.2}, {0.7, 0.3, 0.15}, 0.06}, -0.8);
  layout.ellipsoid({-0.42, -0.84, -0.2}, {0.07, 0.07, 0.07});
  layout.ellipsoid({-0.5, -0.84, -0.05}, {0.07, 0.07, 0.07});
  layout.style({P::planks, {0.50, 0.40, 0.30}, {0.36, 0.27, 0.19}, 0.09}, -0.4);  // bench
  layout.box({0, -0.42, 1.75}, {1.6, 0.05, 0.42}, true);
  layout.box({0, -0.5, 1.97}, {1.6, 0.45, 0.05});
  for (const double side : {-0.7, 0.7}) layout.box({side, 0, 1.78}, {0.07, 0.42, 0.36});
}

void tree(SynthLayout& layout, V foot, double height, double crown, std::uint64_t number) {
  SynthPatch& bark = layout.style({P::mottled, {0.34, 0.26, 0.19}, {0.22, 0.16, 0.11}, 0.12}, detail_at(foot) - 0.1);
  bark.grain = {0, -1, 0};
  layout.cylinder(foot, foot - V(0, 0.62 * height, 0), 0.055 * height);
  CounterRandom random(7, 71, number);
  const V top = foot - V(0, height - 0.5 * crown, 0);
  const double autumn = random.uniform();
  for (int i = 0; i < 9; ++i) {
    const V at = top + 0.62 * crown * random.direction() * V(1, 0.7, 1);
    layout.style({P::mottled, {0.13 + 0.2 * autumn, 0.30, 0.09}, {0.34 + 0.25 * autumn, 0.50, 0.16}, 0.5},
                 detail_at(foot) + 0.05);
    layout.leaves(at, V(0.55, 0.42, 0.55) * crown * random.uniform(0.7, 1.1), 0.11);
    bark = layout.style({P::mottled, {0.34, 0.26, 0.19}, {0.22, 0.16, 0.11}, 0.12}, detail_at(foot));
    layout.cylinder(foot - V(0, 0.55 * height, 0), at, 0.02 * height);
  }
}

void rim(SynthLayout& layout) {
  layout.style({P::bricks, {0.66, 0.36, 0.27}, {0.80, 0.74, 0.66}, 0.16}, detail_at({0, 0, 10.5}) - 0.5);  // house
  layout.quad({-6, -5.2, 10.5}, {0, 5.2, 0}, {12, 0, 0}, 2.0);  // y cross x = -z: towards the garden
  layout.quad({-6, -5.2, 10.5}, {0, 0, 3}, {0, 5.2, 0}, 2.0);
  layout.quad({6, -5.2, 10.5}, {0, 5.2, 0}, {0, 0, 3}, 2.0);
  layout.style({P::stripes, {0.42, 0.20, 0.16}, {0.30, 0.14, 0.12}, 0.4}, detail_at({0, 0, 11}) - 0.2);
  layout.quad({-6.4, -5.1, 10.1}, {12.8, 0, 0}, {0, -2.4, 2.6}, 2.0);
  for (const double x : {-4.2, -1.4, 2.6}) {
    for (const double top : {-4.4, -2.0}) {
      layout.style({P::tiles, {0.16, 0.22, 0.30}, {0.92, 0.92, 0.9}, 0.55}, detail_at({0, 0, 10.4}) - 0.6);
      layout.quad({x, top, 10.44}, {0, 1.2, 0}, {1.1, 0, 0}, 2.0);
    }
  }
  layout.style({P::planks, {0.18, 0.34, 0.28}, {0.12, 0.24, 0.2}, 0.2}, detail_at({0, 0, 10.4}) - 0.6);
  layout.quad({0.4, -2.1, 10.43}, {0, 2.1, 0}, {1.1, 0, 0}, 2.0);
  for (const double side : {-11.0, 11.0}) {  // hedges and a fence
    for (int i = 0; i < 9; ++i) {
      const V at(side, -0.8, -9.6 + 2.4 * i);
      layout.style({P::mottled, {0.10, 0.24, 0.09}, {0.26, 0.42, 0.14}, 0.4}, detail_at(at));
      layout.leaves(at, {0.8, 0.95, 1.4}, 0.12);
    }
  }
  SynthPatch& fence = layout.style({P::planks, {0.50, 0.40, 0.30}, {0.28, 0.2, 0.15}, 0.16}, detail_at({0, 0, -11}));
  fence.grain = {0, -1, 0};
  layout.quad({-11, -1.6, -11}, {22, 0, 0}, {0, 1.6, 0}, 2.0);
  const V trees[] = {{-6.2, 0, 5.5}, {6.8, 0, 4.8}, {-7.5, 0, -4.0}, {7.2, 0, -6.2}, {-3.0, 0, -9.0}, {9.3, 0, 9.0}};
  std::uint64_t number = 0;
  for (const V& foot : trees) {
    tree(layout, foot, 4.2 + 0.4 * static_cast<double>(number % 3), 2.0, number);
    ++number;
  }
  const V bushes[] = {{-3.4, -0.4, 3.6}, {3.6, -0.45, 3.2}, {-4.0, -0.35, -2.6},
                      {4.4, -0.4, -1.8}, {2.9, -0.3, -4.4}, {-2.2, -0.3, 5.8}};
  for (const V& at : bushes) {
    const bool flowers = ++number % 2 == 0;
    layout.style({P::mottled, {0.14, 0.32, 0.10}, {0.32, 0.50, 0.16}, 0.3}, detail_at(at) - 0.1);
    layout.leaves(at, {0.8, 0.6, 0.8}, 0.07);
    if (!flowers) continue;
    layout.style({P::mottled, {0.80, 0.30, 0.55}, {0.95, 0.80, 0.85}, 0.1}, detail_at(at) - 0.2);
    layout.leaves(at - V(0, 0.1, 0), {0.84, 0.6, 0.84}, 0.03);
  }
}

}  // namespace

SynthWorld garden_world() {
  SynthWorld world;
  lawn(world.layout);
  table(world.layout);
  rim(world.layout);
  world.layout.style({P::mottled, {0.45, 0.5, 0.4}, {0.6, 0.65, 0.6}, 1.5}).opacity_shift = -2.0;
  world.layout.haze({0, -1.6, 0}, {9, 1.7, 9});
  SynthStatistics& s = world.statistics;
  s.density_sd = 0.55;  // on top of the fall with distance: about 0.9 together
  s.size_mean = -0.38;
  s.size_sd = 0.62;
  s.middle_follows = 0.7;
  s.small_follows = 0.3;
  s.large_to_middle = {2.2, 0.45};
  s.middle_to_small = {1.82, 1.25};
  s.needle_share = 0.3;
  s.smallest_scale = 1e-10;
  s.opacity = {0.09, 0.13, 0.11, 0.10, 0.08, 0.08, 0.07, 0.06, 0.06, 0.22};
  s.opacity_size_correlation = -0.3;
  s.clear_share = 0.001;
  s.coincident_share = 0.003;
  s.haze_share = 0.004;
  world.light = {-0.45, -0.75, -0.5};
  world.ambient = 0.55;
  world.background = true;
  world.middle = {0, -1.5, 0};
  world.diagonal = 24.0;
  world.cameras = {synth_camera("table", {-1.6, -1.6, -2.6}, {0.3, -0.7, 0.6}, 70),
                   synth_camera("house", {2.6, -1.6, -3.4}, {-0.6, -1.3, 4.0}, 70),
                   synth_camera("hedge", {-3.2, -1.7, 0.8}, {3.0, -0.9, -0.8}, 70),
                   synth_camera("high", {4.5, -4.2, -6.5}, {-0.5, -0.6, 1.0}, 65)};
  return world;
}

}  // namespace grtx::frontend
