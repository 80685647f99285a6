// SPDX-License-Identifier: Apache-2.0
// The flat preset: a flat of four furnished rooms behind one wall, seen from inside. Units: metres; y points down.
#include "grtx/frontend/synth/synth_rooms.h"
#include "grtx/frontend/synth/synth_world.h"

namespace grtx::frontend {
namespace {

using V = glm::dvec3;
using P = SynthPattern;

constexpr double kHeight = 2.7;

/// A wall face as high as the rooms.
void wall(SynthLayout& layout, V start, V along, double length, const std::vector<SynthOpening>& openings, bool flip) {
  wall_face(layout, {start, along, length, kHeight, openings}, flip);
}

void shell(SynthLayout& layout) {
  layout.style({P::planks, {0.50, 0.33, 0.19}, {0.31, 0.19, 0.10}, 0.14}, -0.15);
  layout.quad({0, 0, 0}, {5, 0, 0}, {0, 0, 4.2});  // a x b = -y: up
  layout.quad({0, 0, 4.35}, {5, 0, 0}, {0, 0, 2.65});
  layout.style({P::tiles, {0.72, 0.70, 0.66}, {0.45, 0.43, 0.40}, 0.33}, -0.1);
  layout.quad({5.15, 0, 0}, {3.35, 0, 0}, {0, 0, 4.2});
  layout.style({P::mottled, {0.35, 0.38, 0.44}, {0.25, 0.28, 0.33}, 0.1});
  layout.quad({5.15, 0, 4.35}, {3.35, 0, 0}, {0, 0, 2.65});
  layout.style({P::plain, {0.92, 0.91, 0.88}, {0.84, 0.83, 0.8}, 0.8}, 0.35);
  for (const V& corner : {V(0, -kHeight, 0), V(0, -kHeight, 4.35), V(5.15, -kHeight, 0), V(5.15, -kHeight, 4.35)}) {
    layout.quad(corner, {0, 0, corner.z < 1 ? 4.2 : 2.65}, {corner.x < 1 ? 5 : 3.35, 0, 0});
  }
  const V x(1, 0, 0);
  const V z(0, 0, 1);
  const SynthOpening window{1.4, 3.4, 0.9, 2.3};
  const SynthOpening door{2.6, 3.5, 0.0, 2.05};
  layout.style({P::plain, {0.86, 0.80, 0.68}, {0.76, 0.68, 0.55}, 0.9}, 0.15);  // living room
  wall(layout, {0, 0, 0}, x, 5, {window}, false);
  wall(layout, {0, 0, 4.2}, x, 5, {door}, true);
  wall(layout, {5, 0, 0}, z, 4.2, {{1.2, 2.4, 0, 2.05}}, false);
  layout.style({P::bricks, {0.58, 0.30, 0.22}, {0.74, 0.68, 0.62}, 0.11}, -0.05);
  wall(layout, {0, 0, 0}, z, 4.2, {}, true);
  layout.style({P::tiles, {0.80, 0.86, 0.84}, {0.62, 0.66, 0.65}, 0.2}, 0.1);  // kitchen
  wall(layout, {5.15, 0, 0}, x, 3.35, {{0.9, 2.3, 1.0, 2.2}}, false);
  wall(layout, {5.15, 0, 4.2}, x, 3.35, {}, true);
  wall(layout, {5.15, 0, 0}, z, 4.2, {{1.2, 2.4, 0, 2.05}}, true);
  wall(layout, {8.5, 0, 0}, z, 4.2, {}, false);
  layout.style({P::stripes, {0.62, 0.70, 0.76}, {0.72, 0.79, 0.83}, 0.25}, 0.15);  // bedroom
  wall(layout, {0, 0, 4.35}, x, 5, {door}, false);
  wall(layout, {0, 0, 7}, x, 5, {window}, true);
  wall(layout, {0, 0, 4.35}, z, 2.65, {}, true);
  wall(layout, {5, 0, 4.35}, z, 2.65, {}, false);
  layout.style({P::plain, {0.55, 0.66, 0.55}, {0.48, 0.58, 0.48}, 0.9}, 0.15);  // study
  wall(layout, {5.15, 0, 4.35}, x, 3.35, {}, false);
  wall(layout, {5.15, 0, 7}, x, 3.35, {{1.0, 2.2, 1.0, 2.2}}, true);
  wall(layout, {5.15, 0, 4.35}, z, 2.65, {}, true);
  wall(layout, {8.5, 0, 4.35}, z, 2.65, {}, false);
  layout.style({P::mottled, {0.66, 0.63, 0.58}, {0.52, 0.5, 0.46}, 0.5}, 0.9);  // outside faces, hardly captured
  wall(layout, {-0.3, 0, -0.3}, x, 9.1, {}, true);
  wall(layout, {-0.3, 0, 7.3}, x, 9.1, {}, false);
}

void other_rooms(SynthLayout& layout) {
  layout.style({P::planks, {0.78, 0.74, 0.66}, {0.66, 0.61, 0.52}, 0.3});  // kitchen cupboards and worktop
  layout.box({8.17, 0, 2.1}, {0.62, 0.85, 4.1});
  layout.box({6.6, 0, 0.33}, {2.4, 0.85, 0.62});
  layout.box({8.3, -1.45, 2.6}, {0.36, 0.75, 3.0}, true);
  layout.style({P::mottled, {0.22, 0.22, 0.24}, {0.34, 0.34, 0.36}, 0.05}, -0.2);
  layout.box({8.15, -0.85, 2.1}, {0.68, 0.04, 4.1});
  layout.box({6.6, -0.85, 0.35}, {2.4, 0.04, 0.68});
  layout.style({P::plain, {0.72, 0.75, 0.78}, {0.64, 0.67, 0.7}, 0.4}, 0.1);  // refrigerator
  layout.box({5.5, 0, 3.85}, {0.62, 1.8, 0.62});
  layout.style({P::planks, {0.62, 0.45, 0.28}, {0.5, 0.34, 0.2}, 0.12}, -0.2);  // dining table and stools
  layout.box({6.6, -0.72, 2.6}, {1.3, 0.05, 0.85}, true);
  for (const double px : {6.05, 7.15}) {
    for (const double pz : {2.25, 2.95}) {
      layout.cylinder({px, 0, pz}, {px, -0.72, pz}, 0.035);
      layout.cylinder({px, -0.42, pz < 2.6 ? 1.95 : 3.25}, {px, -0.46, pz < 2.6 ? 1.95 : 3.25}, 0.17);
      layout.cylinder({px, 0, pz < 2.6 ? 1.95 : 3.25}, {px, -0.42, pz < 2.6 ? 1.95 : 3.25}, 0.03);
    }
  }
  layout.style({P::mottled, {0.85, 0.2, 0.15}, {0.75, 0.7, 0.2}, 0.06}, -0.5);  // fruit, pots
  for (const double at : {6.4, 6.55, 6.7}) layout.ellipsoid({at, -0.83, 2.55 + 0.3 * (at - 6.5)}, {0.06, 0.06, 0.06});
  layout.cylinder({8.1, -0.89, 1.2}, {8.1, -1.08, 1.2}, 0.12);
  layout.style({P::mottled, {0.86, 0.84, 0.88}, {0.70, 0.70, 0.80}, 0.25}, -0.2);  // bed
  layout.box({1.2, -0.2, 5.9}, {1.7, 0.3, 2.0});
  layout.ellipsoid({1.25, -0.52, 5.7}, {0.85, 0.13, 0.75});
  for (const double at : {0.8, 1.65}) layout.ellipsoid({at, -0.6, 6.65}, {0.33, 0.12, 0.2});
  layout.style({P::planks, {0.45, 0.3, 0.18}, {0.33, 0.21, 0.12}, 0.2});
  layout.box({1.2, 0, 6.95}, {1.8, 0.95, 0.08});
  layout.box({4.65, 0, 5.9}, {0.6, 2.1, 1.6});                                 // wardrobe
  layout.style({P::planks, {0.7, 0.66, 0.6}, {0.58, 0.53, 0.47}, 0.1}, -0.2);  // desk, screen, chair
  layout.box({8.1, -0.7, 5.7}, {0.75, 0.04, 1.5}, true);
  for (const double pz : {5.0, 6.4}) layout.box({8.1, 0, pz}, {0.7, 0.7, 0.05});
  layout.style({P::picture, {0.08, 0.1, 0.16}, {0.3, 0.55, 0.8}, 0.08}, -0.4);
  layout.box({8.3, -0.82, 5.7}, {0.05, 0.4, 0.65});
  layout.style({P::plain, {0.2, 0.2, 0.23}, {0.15, 0.15, 0.18}, 0.1}, -0.2);
  layout.ellipsoid({7.4, -0.48, 5.7}, {0.26, 0.05, 0.26});
  layout.ellipsoid({7.15, -0.85, 5.7}, {0.05, 0.32, 0.24});
  layout.cylinder({7.4, 0, 5.7}, {7.4, -0.45, 5.7}, 0.04);
  layout.style({P::books, {0.55, 0.42, 0.3}, {1, 1, 1}, 0.045}, -0.5);
  layout.box({5.35, 0, 5.7}, {0.34, 1.9, 1.8});
}

/// The view from the windows: a hedge around the house, far away and coarse. Rays that leave a room continue through
/// it, as they do through the other rooms of a captured building.
void garden(SynthLayout& layout) {
  for (int i = 0; i < 7; ++i) {
    for (const double side : {-1.0, 1.0}) {
      layout.style({P::mottled, {0.14, 0.30, 0.10}, {0.40, 0.52, 0.24}, 0.6}, 1.35);
      layout.leaves({-0.9 + 1.7 * i, -1.2, 3.5 + side * 6.0}, {1.1, 1.5, 0.45}, 0.25);
      layout.leaves({4.1 + side * 7.0, -1.2, -1.2 + 1.55 * i}, {0.45, 1.5, 1.0}, 0.25);
    }
  }
}

}  // namespace

SynthWorld flat_world() {
  SynthWorld world;
  shell(world.layout);
  furnish_living_room(world.layout);
  other_rooms(world.layout);
  garden(world.layout);
  world.layout.style({P::mottled, {0.7, 0.66, 0.6}, {0.5, 0.48, 0.45}, 0.8}).opacity_shift = -2.0;
  world.layout.haze({2.5, -1.35, 2.1}, {2.4, 1.3, 2.0});
  world.layout.haze({5.0, -1.35, 4.0}, {4.0, 1.3, 3.2});
  world.statistics = indoor_statistics();
  world.light = {0.25, -0.75, -0.6};
  world.ambient = 0.62;
  world.background = true;
  world.middle = {4.2, -1.2, 3.4};
  world.diagonal = 10.5;
  world.cameras = {synth_camera("living_room", {4.55, -1.5, 0.5}, {1.2, -0.8, 3.0}, 75),
                   synth_camera("window", {4.3, -1.45, 3.9}, {1.8, -1.05, 0.6}, 75),
                   synth_camera("kitchen", {5.6, -1.55, 1.9}, {7.6, -0.8, 2.2}, 80),
                   synth_camera("bedroom", {4.1, -1.5, 4.8}, {1.2, -0.6, 6.2}, 75)};
  return world;
}

}  // namespace grtx::frontend
