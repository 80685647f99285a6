// SPDX-License-Identifier: Apache-2.0
// The hall preset: an exhibition hall with glass cases, seen from inside at people's height; behind its walls a
// corridor, store rooms and an office, before its windows trees. Units: metres; y points down.
#include "grtx/frontend/synth/synth_rooms.h"
#include "grtx/frontend/synth/synth_world.h"

namespace grtx::frontend {
namespace {

using V = glm::dvec3;
using P = SynthPattern;

constexpr double kHallLength = 13.0;  ///< along x
constexpr double kHallWidth = 9.0;    ///< along z
constexpr double kHallHeight = 3.4;
constexpr double kHallCell = 1.2;  ///< of floors, ceilings and walls

/// The hall's visible parts, and what is behind its walls.
class HallBuilder {
 public:
  explicit HallBuilder(SynthLayout& layout) : layout_(layout) {}

  void build() {
    shell();
    exhibition_wall();
    back_rooms();
    outside();
    for (const V& at : {V(4.5, 0, 7.9), V(8.8, 0, 1.7), V(8.8, 0, 7.2)}) column(at);
    for (const V& at : {V(2.0, 0, 1.9), V(1.9, 0, 4.8), V(5.3, 0, 3.0)}) glass_case(at);
    for (const V& at : {V(3.3, 0, 6.8), V(6.9, 0, 1.6), V(7.4, 0, 4.1)}) showcase(at);
    for (const V& at : {V(10.3, 0, 2.3), V(11.2, 0, 4.9), V(10.2, 0, 7.3)}) table_with_chairs(at);
    for (const V& at : {V(0.6, 0, 8.4), V(12.4, 0, 0.6), V(12.4, 0, 8.4)}) plant(at);
    bust({3.5, 0, 3.4});
    bust({6.0, 0, 8.3});
    screen({8.7, 0, 8.4});
    reception({6.9, 0, 8.2});
    layout_.style({P::books, {0.30, 0.20, 0.13}, V(1.0), 0.05}, -0.5);
    layout_.box({12.8, 0, 2.6}, {0.36, 2.2, 2.6});
    layout_.style({P::mottled, {0.7, 0.66, 0.6}, {0.5, 0.48, 0.45}, 0.8}).opacity_shift = -3.5;
    layout_.haze({0.5 * kHallLength, -0.5 * kHallHeight, 0.5 * kHallWidth},
                 {0.48 * kHallLength, 0.45 * kHallHeight, 0.45 * kHallWidth});
  }

 private:
  void shell() {
    layout_.style({P::planks, {0.46, 0.43, 0.39}, {0.24, 0.22, 0.20}, 0.25}, 0.2);  // floor; a x b = -y: up
    layout_.quad({0, 0, 0}, {kHallLength, 0, 0}, {0, 0, kHallWidth}, kHallCell);
    layout_.style({P::tiles, {0.80, 0.79, 0.77}, {0.60, 0.59, 0.57}, 0.6}, 0.7);  // ceiling
    layout_.quad({0, -kHallHeight, 0}, {0, 0, kHallWidth}, {kHallLength, 0, 0}, kHallCell);
    layout_.style({P::plain, {1.0, 1.0, 0.97}, {0.97, 0.98, 1.0}, 0.4}, 0.2);  // lamps
    for (double x = 0.9; x < kHallLength; x += 3.1) {
      for (const double z : {1.5, 4.5, 7.5}) layout_.quad({x, -kHallHeight + 0.1, z}, {0, 0, 0.3}, {1.3, 0, 0});
    }
    const V x(1, 0, 0);
    const V z(0, 0, 1);
    layout_.style({P::plain, {0.87, 0.86, 0.83}, {0.80, 0.79, 0.76}, 0.9}, 0.6);
    const std::vector<SynthOpening> windows{{1.0, 3.4, 0.9, 2.7}, {4.6, 7.0, 0.9, 2.7}, {8.4, 10.8, 0.9, 2.7}};
    wall_face(layout_, {{0, 0, 0}, x, kHallLength, kHallHeight, windows, kHallCell}, false);
    wall_face(layout_, {{0, 0, kHallWidth}, x, kHallLength, kHallHeight, {{10.6, 12.0, 0.0, 2.2}}, kHallCell}, true);
    wall_face(layout_, {{kHallLength, 0, 0}, z, kHallWidth, kHallHeight, {{6.0, 7.4, 0.0, 2.2}}, kHallCell}, false);
    layout_.style({P::plain, {0.94, 0.94, 0.92}, {0.86, 0.86, 0.85}, 0.2}, -0.2);  // window frames
    for (const SynthOpening& window : windows) {
      for (const double at : {window.from, 0.5 * (window.from + window.to), window.to}) {
        layout_.box({at, -window.bottom, 0.0}, {0.07, window.top - window.bottom, 0.09});
      }
      layout_.box({0.5 * (window.from + window.to), -window.bottom, 0.0}, {window.to - window.from, 0.07, 0.12});
    }
  }

  /// Panels with pictures and lines of text, and a door of dark planks; nothing is behind them.
  void exhibition_wall() {
    const V along(0, 0, 1);
    const auto on_wall = [](double z) { return V(0, 0, z); };
    const V colours[] = {{0.93, 0.52, 0.10}, {0.78, 0.77, 0.18}, {0.20, 0.55, 0.60}};
    const SynthOpening door{7.0, 8.5, 0.0, 2.4};
    std::vector<SynthOpening> panels;
    for (int i = 0; i < 3; ++i) panels.push_back({0.4 + 2.2 * i, 2.3 + 2.2 * i, 0.3, 3.0});
    const std::vector<SynthOpening> holes{panels[0], panels[1], panels[2], door};
    layout_.style({P::plain, {0.80, 0.79, 0.78}, {0.72, 0.71, 0.70}, 0.9}, 0.5);
    wall_face(layout_, {{0, 0, 0}, along, kHallWidth, kHallHeight, holes, kHallCell}, true);
    for (int i = 0; i < 3; ++i) {
      const SynthOpening& panel = panels[static_cast<std::size_t>(i)];
      const SynthOpening pictures{0.15, 0.85, 1.75, 2.5};
      const SynthOpening text{1.0, 1.75, 0.5, 2.5};
      layout_.style({P::plain, colours[i], 0.85 * colours[i], 0.5}, 0.2);
      const V foot = on_wall(panel.from) - V(0, panel.bottom, 0);
      wall_face(layout_, {foot, along, panel.to - panel.from, panel.top - panel.bottom, {pictures, text}, kHallCell},
                true);
      layout_.style({P::picture, {0.10, 0.14, 0.20}, {0.95, 0.88, 0.74}, 0.07}, -0.3);
      wall_face(layout_, {foot + V(0, -pictures.bottom, pictures.from), along, 0.7, 0.75, {}, kHallCell}, true);
      layout_.style({P::stripes, {0.12, 0.10, 0.08}, 0.4 + 0.6 * colours[i], 0.12}, -0.3);  // lines of text
      layout_.quad(foot + V(0, -text.top, text.from), {0, 2.0, 0}, {0, 0, 0.75});
    }
    layout_.style({P::planks, {0.24, 0.15, 0.09}, {0.14, 0.08, 0.05}, 0.2}, 0.0);
    wall_face(layout_, {on_wall(door.from), along, door.to - door.from, door.top, {}, kHallCell}, true);
  }

  void back_rooms() {
    layout_.style({P::plain, {0.70, 0.68, 0.64}, {0.62, 0.60, 0.57}, 0.8}, 0.5);
    const V x(1, 0, 0);
    const V z(0, 0, 1);
    wall_face(layout_, {{0, 0, kHallWidth + 0.25}, x, kHallLength, kHallHeight, {{10.6, 12.0, 0.0, 2.2}}, kHallCell},
              false);
    wall_face(layout_, {{0, 0, kHallWidth + 2.4}, x, kHallLength, kHallHeight, {}, kHallCell}, true);
    wall_face(layout_, {{kHallLength + 0.25, 0, 0}, z, kHallWidth, kHallHeight, {{6.0, 7.4, 0.0, 2.2}}, kHallCell},
              true);
    wall_face(layout_, {{kHallLength + 4.0, 0, 0}, z, kHallWidth, kHallHeight, {}, kHallCell}, false);
    wall_face(layout_, {{-0.25, 0, 0}, z, kHallWidth, kHallHeight, {}, kHallCell}, false);
    wall_face(layout_, {{-3.5, 0, 0}, z, kHallWidth, kHallHeight, {}, kHallCell}, true);
    wall_face(layout_,
              {{0, 0, -0.3},
               x,
               kHallLength,
               kHallHeight,
               {{1.0, 3.4, 0.9, 2.7}, {4.6, 7.0, 0.9, 2.7}, {8.4, 10.8, 0.9, 2.7}},
               kHallCell},
              true);
    layout_.style({P::books, {0.35, 0.28, 0.2}, V(1.0), 0.08}, 0.2);
    for (const double at : {1.5, 4.5, 7.5}) layout_.box({-1.6, 0, at}, {0.6, 2.2, 2.0});
    for (const double at : {2.0, 5.5, 9.0}) layout_.box({at, 0, kHallWidth + 3.4}, {2.4, 2.2, 0.6});
    layout_.style({P::tiles, {0.55, 0.53, 0.50}, {0.42, 0.41, 0.39}, 0.5}, 0.4);
    layout_.quad({-3.5, 0, 0}, {3.2, 0, 0}, {0, 0, kHallWidth}, kHallCell);
    layout_.quad({0, 0, kHallWidth + 0.25}, {kHallLength, 0, 0}, {0, 0, 2.2}, kHallCell);
    layout_.style({P::mottled, {0.45, 0.43, 0.40}, {0.36, 0.34, 0.32}, 0.8}, 1.2);  // what a capture leaves below
    layout_.quad({0, 0.25, 0}, {kHallLength, 0, 0}, {0, 0, kHallWidth}, kHallCell);
    layout_.style({P::tiles, {0.55, 0.53, 0.50}, {0.42, 0.41, 0.39}, 0.5}, 0.4);
    layout_.quad({kHallLength + 0.25, 0, 0}, {3.8, 0, 0}, {0, 0, kHallWidth}, kHallCell);
  }

  void outside() {
    for (int i = 0; i < 5; ++i) {
      layout_.style({P::mottled, {0.14, 0.30, 0.10}, {0.40, 0.52, 0.24}, 0.6}, 0.9);
      layout_.leaves({0.3 + 2.9 * i, -1.8, -3.5 - 0.6 * (i % 3)}, {1.5, 1.9, 0.9}, 0.2);
    }
  }

  void column(const V& foot) {
    layout_.style({P::plain, {0.90, 0.90, 0.89}, {0.82, 0.82, 0.81}, 0.5}, 0.1);
    layout_.box(foot, {0.5, kHallHeight, 0.5});
  }

  void glass(const V& foot, const V& size) {
    layout_.style({P::plain, {0.80, 0.84, 0.84}, {0.70, 0.75, 0.76}, 0.5}, 0.7).opacity_shift = -5.0;
    layout_.box(foot, size);
  }

  void edges(const V& foot, const V& size, double width) {
    for (const double dx : {-0.5, 0.5}) {
      for (const double dz : {-0.5, 0.5}) {
        const V post = foot + V(dx * size.x, 0, dz * size.z);
        layout_.cylinder(post, post - V(0, size.y, 0), 0.5 * width);
      }
      const V top = foot - V(0, size.y, 0);
      layout_.cylinder(top + V(dx * size.x, 0, -0.5 * size.z), top + V(dx * size.x, 0, 0.5 * size.z), 0.5 * width);
      layout_.cylinder(top + V(-0.5 * size.x, 0, dx * size.z), top + V(0.5 * size.x, 0, dx * size.z), 0.5 * width);
    }
  }

  /// A low case: a white base, drawings and small things under glass.
  void glass_case(const V& foot) {
    layout_.style({P::plain, {0.83, 0.83, 0.82}, {0.74, 0.74, 0.74}, 0.4}, -0.1);
    layout_.box(foot, {1.1, 0.79, 2.0});
    layout_.style({P::picture, {0.90, 0.45, 0.20}, {0.95, 0.92, 0.85}, 0.06}, -0.6);
    layout_.quad(foot + V(-0.4, -0.82, -0.8), {0.8, 0, 0}, {0, 0, 0.7});
    layout_.style({P::picture, {0.20, 0.25, 0.35}, {0.90, 0.88, 0.80}, 0.05}, -0.6);
    layout_.quad(foot + V(-0.4, -0.82, 0.1), {0.5, 0, 0}, {0, 0, 0.6});
    layout_.style({P::mottled, {0.55, 0.38, 0.20}, {0.35, 0.22, 0.12}, 0.08}, -0.6);
    layout_.ellipsoid(foot + V(0.3, -0.9, 0.4), {0.09, 0.09, 0.09});
    layout_.cylinder(foot + V(-0.2, -0.85, 0.85), foot + V(0.3, -0.85, 0.8), 0.03);
    glass(foot + V(0, -0.8, 0), {1.1, 0.35, 2.0});
    layout_.style({P::plain, {0.60, 0.61, 0.62}, {0.45, 0.46, 0.48}, 0.1}, -0.4);
    edges(foot + V(0, -0.8, 0), {1.1, 0.35, 2.0}, 0.03);
  }

  /// A tall one: a frame of dark steel, shelves with books, vases and papers.
  void showcase(const V& foot) {
    constexpr V kSize(0.9, 1.9, 0.7);
    layout_.style({P::mottled, {0.16, 0.10, 0.08}, {0.24, 0.15, 0.12}, 0.2}, -0.4);
    edges(foot, kSize, 0.05);
    for (const double height : {0.15, 0.7, 1.25}) {
      layout_.style({P::mottled, {0.16, 0.10, 0.08}, {0.24, 0.15, 0.12}, 0.2}, -0.3);
      layout_.box(foot - V(0, height, 0), {kSize.x, 0.03, kSize.z}, true);
      layout_.style({P::picture, {0.15, 0.45, 0.40}, {0.90, 0.80, 0.30}, 0.05}, -0.6);
      layout_.box(foot + V(-0.2, -height - 0.03, 0), {0.35, 0.04, 0.4});
      layout_.style({P::stripes, {0.85, 0.30, 0.15}, {0.92, 0.85, 0.75}, 0.05}, -0.6);
      layout_.ellipsoid(foot + V(0.2, -height - 0.15, 0.05), {0.08, 0.12, 0.08});
    }
    glass(foot, kSize);
  }

  void table_with_chairs(const V& foot) {
    layout_.style({P::plain, {0.86, 0.84, 0.80}, {0.78, 0.76, 0.72}, 0.3}, -0.1);
    layout_.ellipsoid(foot - V(0, 0.73, 0), {0.6, 0.025, 0.6});
    layout_.style({P::plain, {0.30, 0.30, 0.32}, {0.20, 0.20, 0.22}, 0.1}, -0.2);
    layout_.cylinder(foot, foot - V(0, 0.72, 0), 0.05);
    layout_.ellipsoid(foot - V(0, 0.03, 0), {0.3, 0.03, 0.3});
    const V seats[] = {{0.16, 0.28, 0.62}, {0.42, 0.12, 0.38}, {0.16, 0.28, 0.62}, {0.80, 0.35, 0.12}};
    const V sides[] = {{0.85, 0, 0.1}, {-0.85, 0, -0.1}, {0.1, 0, 0.85}, {-0.1, 0, -0.85}};
    for (int i = 0; i < 4; ++i) {
      const V at = foot + sides[i];
      const V back = foot + 1.28 * sides[i];
      layout_.style({P::mottled, seats[i], 0.7 * seats[i], 0.1}, -0.3);
      layout_.ellipsoid(at - V(0, 0.45, 0), {0.24, 0.05, 0.24});
      layout_.ellipsoid(back - V(0, 0.72, 0), i < 2 ? V(0.04, 0.22, 0.22) : V(0.22, 0.22, 0.04));
      layout_.style({P::plain, {0.35, 0.35, 0.37}, {0.25, 0.25, 0.27}, 0.1}, -0.2);
      layout_.cylinder(at, at - V(0, 0.42, 0), 0.025);
      layout_.cylinder(back - V(0, 0.42, 0), back - V(0, 0.6, 0), 0.02);
      layout_.ellipsoid(at - V(0, 0.02, 0), {0.2, 0.02, 0.2});
    }
  }

  void plant(const V& foot) {
    layout_.style({P::mottled, {0.65, 0.35, 0.22}, {0.50, 0.26, 0.17}, 0.1}, -0.1);
    layout_.cylinder(foot, foot - V(0, 0.5, 0), 0.22);
    layout_.style({P::mottled, {0.14, 0.38, 0.12}, {0.33, 0.56, 0.20}, 0.15}, -0.3);
    layout_.leaves(foot - V(0, 1.1, 0), {0.5, 0.55, 0.5}, 0.07);
    layout_.leaves(foot - V(0, 1.7, 0), {0.35, 0.4, 0.35}, 0.07);
  }

  void bust(const V& foot) {
    layout_.style({P::mottled, {0.32, 0.31, 0.30}, {0.22, 0.21, 0.21}, 0.15}, 0.0);
    layout_.box(foot, {0.42, 1.05, 0.42});
    layout_.style({P::mottled, {0.55, 0.42, 0.22}, {0.40, 0.28, 0.14}, 0.06}, -0.5);
    layout_.ellipsoid(foot - V(0, 1.2, 0), {0.24, 0.18, 0.14});
    layout_.cylinder(foot - V(0, 1.3, 0), foot - V(0, 1.45, 0), 0.06);
    layout_.ellipsoid(foot - V(0, 1.56, 0), {0.1, 0.14, 0.12});
  }

  /// A television on a stand.
  void screen(const V& foot) {
    layout_.style({P::plain, {0.12, 0.12, 0.13}, {0.08, 0.08, 0.09}, 0.1}, -0.2);
    layout_.box(foot, {0.7, 0.04, 0.45});
    layout_.cylinder(foot, foot - V(0, 1.1, 0), 0.04);
    layout_.style({P::picture, {0.05, 0.10, 0.30}, {0.30, 0.65, 0.90}, 0.10}, -0.3);
    layout_.box(foot - V(0, 1.05, 0), {1.3, 0.75, 0.06});
  }

  void reception(const V& foot) {
    layout_.style({P::planks, {0.62, 0.45, 0.28}, {0.50, 0.34, 0.20}, 0.15}, -0.1);
    layout_.box(foot, {2.4, 1.05, 0.6});
    layout_.style({P::plain, {0.90, 0.90, 0.88}, {0.80, 0.80, 0.79}, 0.3}, -0.1);
    layout_.box(foot - V(0, 1.05, 0), {2.6, 0.05, 0.75}, true);
    layout_.style({P::picture, {0.85, 0.80, 0.70}, {0.60, 0.20, 0.20}, 0.05}, -0.5);
    layout_.box(foot + V(-0.6, -1.1, 0), {0.4, 0.12, 0.3});
  }

  SynthLayout& layout_;
};

}  // namespace

SynthWorld hall_world() {
  SynthWorld world;
  HallBuilder(world.layout).build();
  world.statistics = whole_scene_statistics();
  world.light = {0.25, -0.75, -0.6};
  world.ambient = 0.66;
  world.background = true;
  world.middle = {0.5 * kHallLength, -1.4, 0.5 * kHallWidth};
  world.diagonal = 15.0;
  world.cameras = {synth_camera("cases", {8.6, -1.7, 6.3}, {0.3, -0.8, 3.2}, 65),
                   synth_camera("along", {0.9, -1.7, 6.4}, {9.0, -0.9, 3.4}, 65),
                   synth_camera("tables", {5.2, -1.7, 0.9}, {12.0, -0.8, 5.2}, 65),
                   synth_camera("windows", {11.9, -1.7, 6.3}, {4.5, -0.9, 1.6}, 65)};
  return world;
}

}  // namespace grtx::frontend
