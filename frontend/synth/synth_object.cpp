// SPDX-License-Identifier: Apache-2.0
// The object preset: a figure on a pedestal in front of nothing, as a cut-out capture. Units: metres; y points down.
#include "grtx/frontend/synth/synth_world.h"

namespace grtx::frontend {
namespace {

using V = glm::dvec3;
using P = SynthPattern;

void pedestal(SynthLayout& layout) {
  layout.style({P::mottled, {0.62, 0.58, 0.52}, {0.48, 0.45, 0.41}, 0.15}, 0.1);
  layout.box({0, 1.0, 0}, {1.3, 0.16, 1.3}, true);
  layout.box({0, 0.84, 0}, {1.1, 0.12, 1.1});
  layout.style({P::tiles, {0.70, 0.66, 0.60}, {0.42, 0.39, 0.35}, 0.45});
  layout.box({0, 0.72, 0}, {0.86, 0.9, 0.86});
  layout.style({P::mottled, {0.62, 0.58, 0.52}, {0.48, 0.45, 0.41}, 0.15});
  layout.box({0, -0.18, 0}, {1.04, 0.1, 1.04}, true);
  layout.style({P::picture, {0.50, 0.36, 0.16}, {0.82, 0.66, 0.32}, 0.03}, -0.3);  // bronze plate
  layout.quad({-0.25, 0.15, -0.437}, {0, 0.32, 0}, {0.5, 0, 0});
}

void robot(SynthLayout& layout) {
  layout.style({P::mottled, {0.82, 0.44, 0.16}, {0.92, 0.60, 0.26}, 0.12}, -0.15);  // body
  layout.ellipsoid({0, -0.98, 0}, {0.34, 0.42, 0.26});
  layout.style({P::mottled, {0.80, 0.80, 0.78}, {0.66, 0.68, 0.70}, 0.12}, -0.2);
  layout.ellipsoid({0, -1.68, 0}, {0.27, 0.24, 0.24});
  layout.cylinder({0, -1.36, 0}, {0, -1.5, 0}, 0.09);
  layout.style({P::plain, {0.08, 0.10, 0.14}, {0.14, 0.17, 0.22}, 0.1}, -0.4);  // visor and eyes
  layout.ellipsoid({0, -1.68, -0.11}, {0.21, 0.13, 0.15});
  layout.style({P::plain, {0.35, 0.9, 0.95}, {0.25, 0.75, 0.9}, 0.02}, -0.9);
  for (const double side : {-0.09, 0.09}) layout.ellipsoid({side, -1.69, -0.24}, {0.04, 0.05, 0.025});
  layout.style({P::stripes, {0.30, 0.31, 0.34}, {0.45, 0.46, 0.5}, 0.04}, -0.25);  // limbs
  for (const double side : {-1.0, 1.0}) {
    layout.cylinder({side * 0.32, -1.2, 0}, {side * 0.6, -0.95, -0.12}, 0.065);
    layout.cylinder({side * 0.6, -0.95, -0.12}, {side * 0.55, -0.7, -0.38}, 0.055);
    layout.cylinder({side * 0.15, -0.65, 0}, {side * 0.19, -0.28, 0}, 0.085);
  }
  layout.style({P::mottled, {0.82, 0.44, 0.16}, {0.92, 0.60, 0.26}, 0.12}, -0.25);  // joints, hands, feet
  for (const double side : {-1.0, 1.0}) {
    layout.ellipsoid({side * 0.33, -1.2, 0}, {0.11, 0.11, 0.11});
    layout.ellipsoid({side * 0.6, -0.95, -0.12}, {0.08, 0.08, 0.08});
    layout.ellipsoid({side * 0.55, -0.66, -0.42}, {0.08, 0.09, 0.08});
    layout.ellipsoid({side * 0.19, -0.33, -0.06}, {0.12, 0.06, 0.18});
  }
  layout.style({P::plain, {0.15, 0.15, 0.17}, {0.25, 0.25, 0.28}, 0.05}, -0.2);  // aerial
  layout.cylinder({0.12, -1.88, 0.05}, {0.2, -2.18, 0.05}, 0.015);
  layout.style({P::plain, {0.9, 0.15, 0.12}, {0.8, 0.1, 0.1}, 0.05}, -0.4);
  layout.ellipsoid({0.2, -2.21, 0.05}, {0.045, 0.045, 0.045});
  layout.style({P::mottled, {0.16, 0.38, 0.12}, {0.40, 0.58, 0.20}, 0.1}, -0.1);  // flowers it carries
  layout.leaves({-0.5, -0.86, -0.5}, {0.16, 0.14, 0.16}, 0.05);
  layout.style({P::mottled, {0.86, 0.24, 0.40}, {0.98, 0.80, 0.30}, 0.08}, -0.2);
  layout.leaves({-0.5, -1.0, -0.5}, {0.17, 0.1, 0.17}, 0.04);
}

}  // namespace

SynthWorld object_world() {
  SynthWorld world;
  pedestal(world.layout);
  robot(world.layout);
  SynthStatistics& s = world.statistics;
  s.density_sd = 0.45;
  s.size_mean = 0.1;
  s.size_sd = 0.8;
  s.middle_follows = 0.6;
  s.small_follows = 0.15;
  s.aligned_share = 0.57;
  s.cone = 0.2;
  s.thickness = 0.38;
  s.large_to_middle = {3.0, 0.48};
  s.middle_to_small = {1.85, 1.3};
  s.smallest_scale = 1e-9;
  s.opacity = {0.25, 0.15, 0.09, 0.07, 0.06, 0.05, 0.05, 0.05, 0.06, 0.17};
  s.opacity_size_correlation = -0.3;
  s.clear_share = 0.003;
  s.haze_share = 0.0;
  world.light = {-0.5, -0.65, -0.6};
  world.ambient = 0.5;
  world.middle = {0, -0.6, 0};
  world.diagonal = 3.2;
  world.cameras = {synth_camera("front", {-0.9, -1.2, -4.4}, {0, -0.6, 0}, 45),
                   synth_camera("left", {-4.2, -1.5, -1.2}, {0, -0.6, 0}, 45),
                   synth_camera("back", {2.2, -0.9, 3.8}, {0, -0.6, 0}, 45),
                   synth_camera("close", {-0.7, -1.5, -2.0}, {0, -1.25, 0}, 45)};
  return world;
}

}  // namespace grtx::frontend
