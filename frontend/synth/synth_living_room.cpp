// SPDX-License-Identifier: Apache-2.0
// A furnished living room, 5 m by 4.2 m: the first room of the flat preset and all of the room preset. Units: metres;
// y points down.
#include "grtx/frontend/synth/synth_rooms.h"
#include "grtx/frontend/synth/synth_world.h"

namespace grtx::frontend {
namespace {

using V = glm::dvec3;
using P = SynthPattern;

constexpr double kCeiling = 2.7;

void room_shell(SynthLayout& layout) {
  layout.style({P::planks, {0.50, 0.33, 0.19}, {0.31, 0.19, 0.10}, 0.14});
  layout.quad({0, 0, 0}, {5, 0, 0}, {0, 0, 4.2});  // a x b = -y: up
  layout.style({P::plain, {0.92, 0.91, 0.88}, {0.84, 0.83, 0.8}, 0.8}, 0.6);
  layout.quad({0, -kCeiling, 0}, {0, 0, 4.2}, {5, 0, 0});
  layout.style({P::plain, {0.86, 0.80, 0.68}, {0.76, 0.68, 0.55}, 0.9}, 0.5);
  wall_face(layout, {{0, 0, 0}, {1, 0, 0}, 5, kCeiling, {{1.4, 3.4, 0.9, 2.3}}}, false);
  wall_face(layout, {{0, 0, 4.2}, {1, 0, 0}, 5, kCeiling, {{2.6, 3.5, 0.0, 2.05}}}, true);
  wall_face(layout, {{5, 0, 0}, {0, 0, 1}, 4.2, kCeiling, {}}, false);
  layout.style({P::bricks, {0.58, 0.30, 0.22}, {0.74, 0.68, 0.62}, 0.11}, -0.2);
  wall_face(layout, {{0, 0, 0}, {0, 0, 1}, 4.2, kCeiling, {}}, true);
  layout.style({P::planks, {0.40, 0.26, 0.15}, {0.33, 0.21, 0.12}, 0.3}, -0.1);  // door
  layout.quad({2.6, -2.05, 4.22}, {0, 2.05, 0}, {0.9, 0, 0});
  layout.style({P::plain, {0.95, 0.95, 0.93}, {0.88, 0.88, 0.86}, 0.2}, -0.3);  // window frame
  for (const double at : {1.4, 2.4, 3.4}) layout.box({at, -0.9, 0.0}, {0.06, 1.4, 0.08});
  layout.box({2.4, -0.9, 0.0}, {2.0, 0.06, 0.08});
  layout.box({2.4, -2.27, 0.0}, {2.0, 0.06, 0.08});
  layout.style({P::mottled, {0.14, 0.30, 0.10}, {0.40, 0.52, 0.24}, 0.6}, 0.9);  // hedge before the window
  layout.leaves({1.4, -1.0, -2.2}, {1.6, 1.2, 0.5}, 0.2);
  layout.leaves({4.0, -1.0, -2.4}, {1.5, 1.2, 0.5}, 0.2);
}

/// The rooms behind the walls, as a capture of this one room leaves them.
void other_side(SynthLayout& layout) {
  const V x(1, 0, 0);
  const V z(0, 0, 1);
  layout.style({P::plain, {0.70, 0.68, 0.64}, {0.62, 0.60, 0.57}, 0.8}, 0.4);
  wall_face(layout, {{-0.2, 0, 0}, z, 4.2, kCeiling, {}}, false);
  wall_face(layout, {{-3.0, 0, 0}, z, 4.2, kCeiling, {}}, true);
  wall_face(layout, {{5.2, 0, 0}, z, 4.2, kCeiling, {}}, true);
  wall_face(layout, {{8.0, 0, 0}, z, 4.2, kCeiling, {}}, false);
  wall_face(layout, {{0, 0, 4.4}, x, 5, kCeiling, {}}, false);
  wall_face(layout, {{0, 0, 6.6}, x, 5, kCeiling, {}}, true);
  wall_face(layout, {{0, 0, -0.25}, x, 5, kCeiling, {{1.4, 3.4, 0.9, 2.3}}}, true);
  layout.style({P::mottled, {0.45, 0.43, 0.40}, {0.36, 0.34, 0.32}, 0.8}, 1.2);  // what a capture leaves below
  layout.quad({0, 0.25, 0}, {5, 0, 0}, {0, 0, 4.2});
  layout.style({P::books, {0.35, 0.28, 0.2}, V(1.0), 0.08}, 0.2);
  layout.box({-1.4, 0, 2.1}, {0.6, 2.0, 2.6});
  layout.box({6.4, 0, 2.1}, {0.6, 2.0, 2.6});
  layout.box({2.0, 0, 5.6}, {2.6, 2.0, 0.6});
}

}  // namespace

void furnish_living_room(SynthLayout& layout) {
  layout.style({P::mottled, {0.62, 0.20, 0.18}, {0.80, 0.66, 0.42}, 0.18}, -0.35);  // rug
  layout.quad({1.3, -0.02, 1.2}, {2.6, 0, 0}, {0, 0, 1.9}, 0.7);
  layout.style({P::mottled, {0.20, 0.33, 0.48}, {0.28, 0.43, 0.58}, 0.08}, -0.3);  // sofa against the brick wall
  layout.box({0.55, -0.12, 2.1}, {0.9, 0.32, 2.2});
  layout.box({0.2, -0.12, 2.1}, {0.26, 0.78, 2.2});
  layout.box({0.55, -0.12, 0.93}, {0.9, 0.55, 0.2});
  layout.box({0.55, -0.12, 3.27}, {0.9, 0.55, 0.2});
  for (const double at : {1.4, 2.1, 2.8}) layout.ellipsoid({0.6, -0.48, at}, {0.4, 0.1, 0.33});
  layout.style({P::stripes, {0.88, 0.62, 0.15}, {0.80, 0.48, 0.10}, 0.06}, -0.4);
  layout.ellipsoid({0.48, -0.68, 1.25}, {0.12, 0.2, 0.2});
  layout.ellipsoid({0.48, -0.68, 2.95}, {0.12, 0.2, 0.2});
  layout.style({P::planks, {0.36, 0.22, 0.12}, {0.26, 0.15, 0.08}, 0.1}, -0.3);  // table
  layout.box({2.5, -0.38, 2.15}, {1.2, 0.05, 0.7}, true);
  for (const double px : {2.0, 3.0}) {
    for (const double pz : {1.87, 2.43}) layout.cylinder({px, 0, pz}, {px, -0.38, pz}, 0.03);
  }
  layout.style({P::plain, {0.85, 0.85, 0.82}, {0.75, 0.78, 0.8}, 0.1}, -0.5);  // vase, bowl
  layout.ellipsoid({2.3, -0.55, 2.1}, {0.09, 0.13, 0.09});
  layout.style({P::mottled, {0.9, 0.45, 0.1}, {0.8, 0.25, 0.08}, 0.05}, -0.5);
  layout.ellipsoid({2.75, -0.47, 2.2}, {0.14, 0.06, 0.14});
  layout.style({P::books, {0.30, 0.19, 0.11}, {1, 1, 1}, 0.05}, -0.55);  // bookcase
  layout.box({4.82, 0, 3.3}, {0.32, 2.1, 1.5});
  layout.style({P::plain, {0.9, 0.9, 0.88}, {0.8, 0.8, 0.78}, 0.3}, -0.1);  // television bench
  layout.box({4.78, 0, 0.65}, {0.4, 0.45, 1.0});
  layout.style({P::picture, {0.05, 0.06, 0.09}, {0.15, 0.25, 0.4}, 0.1}, -0.2);
  layout.box({4.86, -0.5, 0.65}, {0.06, 0.55, 0.95});
  layout.style({P::plain, {0.15, 0.15, 0.16}, {0.1, 0.1, 0.1}, 0.1}, -0.2);  // lamp
  layout.cylinder({0.35, 0, 3.75}, {0.35, -1.5, 3.75}, 0.02);
  layout.style({P::plain, {1.0, 0.93, 0.75}, {0.95, 0.85, 0.6}, 0.2}, -0.2);
  layout.cylinder({0.35, -1.45, 3.75}, {0.35, -1.8, 3.75}, 0.2);
  layout.style({P::mottled, {0.65, 0.35, 0.22}, {0.5, 0.26, 0.17}, 0.1}, -0.2);  // plant
  layout.cylinder({0.5, 0, 0.45}, {0.5, -0.4, 0.45}, 0.19);
  layout.style({P::mottled, {0.16, 0.40, 0.14}, {0.35, 0.58, 0.2}, 0.15}, -0.35);
  layout.leaves({0.55, -1.0, 0.5}, {0.42, 0.5, 0.38}, 0.07);
  layout.leaves({0.5, -1.45, 0.45}, {0.3, 0.3, 0.3}, 0.07);
  layout.style({P::stripes, {0.75, 0.30, 0.25}, {0.58, 0.2, 0.18}, 0.16}, -0.15);  // curtains beside the window
  layout.quad({0.95, -2.5, 0.08}, {0.5, 0, 0}, {0, 2.3, 0});
  layout.quad({3.35, -2.5, 0.08}, {0.5, 0, 0}, {0, 2.3, 0});
  const V places[] = {{0.03, -2.1, 1.2}, {0.03, -1.95, 2.3}, {0.03, -2.1, 3.1}};
  int number = 0;
  for (const V& place : places) {  // pictures on the brick wall
    layout.style({P::picture, {0.12, 0.25, 0.45}, number == 1 ? V(0.95, 0.75, 0.3) : V(0.9, 0.85, 0.8), 0.06}, -0.5);
    layout.quad(place, {0, 0.6, 0}, {0, 0, number == 1 ? 0.5 : 0.75});
    ++number;
  }
}

SynthWorld room_world() {
  SynthWorld world;
  room_shell(world.layout);
  other_side(world.layout);
  // A capture of one room spends its Gaussians on the contents: furniture is twice as fine as in the flat, walls are
  // coarser.
  const std::size_t furniture = world.layout.patches().size();
  furnish_living_room(world.layout);
  world.layout.refine(furniture, 0.4);
  world.layout.style({P::mottled, {0.7, 0.66, 0.6}, {0.5, 0.48, 0.45}, 0.8}).opacity_shift = -3.5;
  world.layout.haze({2.5, -1.35, 2.1}, {2.4, 1.3, 2.0});
  world.statistics = whole_scene_statistics();
  world.statistics.size_mean = -0.39;
  world.statistics.haze_share = 0.0003;
  world.light = {0.25, -0.75, -0.6};
  world.ambient = 0.62;
  world.background = true;
  world.middle = {2.5, -1.2, 2.1};
  world.diagonal = 6.0;
  world.cameras = {synth_camera("sofa", {4.55, -1.5, 0.5}, {1.2, -0.8, 2.6}, 70),
                   synth_camera("window", {4.3, -1.45, 3.8}, {1.8, -1.05, 0.6}, 70),
                   synth_camera("bookcase", {0.9, -1.5, 0.8}, {4.4, -0.9, 2.8}, 70),
                   synth_camera("door", {1.2, -1.5, 0.6}, {3.2, -0.9, 4.2}, 70)};
  return world;
}

}  // namespace grtx::frontend
