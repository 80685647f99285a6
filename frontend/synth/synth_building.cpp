// SPDX-License-Identifier: Apache-2.0
// The building preset: slab blocks of four storeys with balconies on a lawn with trees, roads and pools, seen from
// outside and above, cut out of its surroundings. Units: metres; y points down.
#include <cmath>
#include <glm/geometric.hpp>

#include "grtx/frontend/synth/synth_rooms.h"
#include "grtx/frontend/synth/synth_world.h"

namespace grtx::frontend {
namespace {

using V = glm::dvec3;
using P = SynthPattern;

constexpr double kSiteStorey = 3.4;
constexpr double kBay = 6.0;  ///< between two walls of a facade
constexpr int kCellsX = 20;   ///< of the ground
constexpr int kCellsZ = 15;
constexpr double kGroundCell = 4.5;

/// A block of flats: from the corner at its foot, `along` its visible facade, which is on the left when walking along
/// it, and `deep` into the house.
struct Block {
  V corner, along, deep;
  int bays, storeys;
  double depth;
};

class SiteBuilder {
 public:
  explicit SiteBuilder(SynthLayout& layout) : layout_(layout) {}

  void build() {
    ground();
    const V x(1, 0, 0);
    const V z(0, 0, 1);
    block({{-27, 0, -4}, x, z, 6, 3, 10.0});
    block({{14, 0, -2}, glm::normalize(V(0.8, 0, 0.6)), glm::normalize(V(-0.6, 0, 0.8)), 3, 3, 10.0});
    block({{-34, 0, 16}, x, z, 4, 4, 10.0});
    white_house({6, 0, 18});
    octagon({-1, 0, -15});
    for (int i = 0; i < 4; ++i) small_house({-36.0 + 9.0 * i, 0, 30.5}, i);
    for (int i = 0; i < 9; ++i) car({-30.0 + 6.6 * i + 0.9 * (i % 3), 0, i % 2 == 0 ? -25.6 : -28.2}, i);
    CounterRandom random(7, 0xb01d, 1);
    int trees = 0;
    for (int tries = 0; trees < 34 && tries < 400; ++tries) {
      const double tx = random.uniform(-42.0, 42.0);
      const double tz = random.uniform(-31.0, 31.0);
      const double height = random.uniform(5.0, 8.0);
      if (kind_at(tx, tz) != Kind::lawn || built_up(tx, tz)) continue;
      tree({tx, 0, tz}, height, static_cast<std::uint64_t>(trees));
      ++trees;
    }
    layout_.style({P::mottled, {0.45, 0.5, 0.4}, {0.6, 0.65, 0.6}, 1.5}).opacity_shift = -3.5;
    layout_.haze({0, -6, 0}, {38, 7, 28});
  }

 private:
  enum class Kind { lawn, road, path, court };

  static Kind kind_at(double x, double z) {
    if (std::abs(z + 27.0) < 3.0) return Kind::road;
    if (std::abs(x - 38.0) < 3.0 && z > -27.0) return Kind::road;
    if (x > -2.0 && x < 27.0 && z > 9.0 && z < 31.0) return Kind::court;
    if (std::abs(x - 9.0) < 2.3 && z < 9.0) return Kind::path;
    return Kind::lawn;
  }
  /// Whether a house is there, with a margin for the trees' crowns.
  static bool built_up(double x, double z) {
    return (x > -30 && x < 13 && z > -8 && z < 10) || (x > 5 && x < 32 && z > -6 && z < 31) ||
           (x > -37 && x < -6 && z > 12 && z < 33) || (x > -11 && x < 9 && z > -24 && z < -6);
  }

  void ground() {
    for (int i = 0; i < kCellsX; ++i) {
      for (int j = 0; j < kCellsZ; ++j) {
        const V corner((i - kCellsX / 2) * kGroundCell, 0, (j - kCellsZ / 2) * kGroundCell);
        const V middle = corner + V(0.5 * kGroundCell, 0, 0.5 * kGroundCell);
        switch (kind_at(middle.x, middle.z)) {
          case Kind::lawn:
            layout_.style({P::mottled, {0.16, 0.29, 0.08}, {0.33, 0.44, 0.16}, 1.2}, 0.4);
            break;
          case Kind::road:
            layout_.style({P::plain, {0.34, 0.34, 0.36}, {0.28, 0.28, 0.30}, 0.8}, 0.2);
            break;
          case Kind::path:
            layout_.style({P::bricks, {0.68, 0.36, 0.20}, {0.55, 0.30, 0.18}, 0.6}, 0.0);
            break;
          case Kind::court:
            layout_.style({P::tiles, {0.70, 0.55, 0.42}, {0.55, 0.42, 0.33}, 1.0}, 0.0);
            break;
        }
        layout_.ground(corner, {kGroundCell, 0, 0}, {0, 0, kGroundCell}, kGroundCell);
      }
    }
    layout_.style({P::mottled, {0.30, 0.24, 0.17}, {0.22, 0.18, 0.13}, 1.5}, 0.6);  // what a capture leaves below it
    layout_.quad({-0.5 * kCellsX * kGroundCell, 0.7, -0.5 * kCellsZ * kGroundCell}, {kCellsX * kGroundCell, 0, 0},
                 {0, 0, kCellsZ * kGroundCell}, 2.0 * kGroundCell);
    layout_.style({P::stripes, {0.92, 0.92, 0.88}, {0.36, 0.36, 0.38}, 6.0}, -0.2);  // the road's middle line
    for (int i = 0; i < 9; ++i) layout_.quad({-44.0 + 10.0 * i, -0.2, -27.1}, {4.0, 0, 0}, {0, 0, 0.25}, 4.0);
  }

  /// A box with a rotated ground plan: origin at a corner of the foot.
  void turned_box(const V& corner, const V& a, const V& b, double height) {
    const V up(0, -height, 0);
    layout_.quad(corner + up, a, b, 3.0);  // top
    layout_.quad(corner + up, -up, a, 3.0);
    layout_.quad(corner + b + up, a, -up, 3.0);
    layout_.quad(corner + up, b, -up, 3.0);
    layout_.quad(corner + a + up, -up, b, 3.0);
  }

  void block(const Block& b) {
    const double length = b.bays * kBay;
    const double height = b.storeys * kSiteStorey;
    const V a = length * b.along;
    const V d = b.depth * b.deep;
    for (int storey = 0; storey < b.storeys; ++storey) {
      const V floor = b.corner - V(0, storey * kSiteStorey, 0);
      const V top = floor - V(0, kSiteStorey, 0);
      for (const bool back : {false, true}) {
        const V edge = back ? d : V(0.0);
        const V in = (back ? -1.0 : 1.0) * b.deep;
        // The slab's edge, the balcony's rail in front of it, the recessed wall with its windows.
        layout_.style({P::plain, {0.72, 0.71, 0.68}, {0.62, 0.61, 0.58}, 0.6}, -0.15);
        face(floor + edge - V(0, 1.1, 0), {0, 1.1, 0}, a, back);
        layout_.style({P::plain, {0.60, 0.58, 0.55}, {0.50, 0.48, 0.46}, 0.6}, 0.1);
        layout_.quad(floor + edge, back ? 1.8 * in : a, back ? a : 1.8 * in, 3.0);
        for (int bay = 0; bay < b.bays; ++bay) {
          const V at = floor + edge + 1.8 * in + (bay * kBay) * b.along - V(0, kSiteStorey, 0);
          layout_.style({P::plain, {0.46, 0.30, 0.22}, {0.38, 0.24, 0.17}, 0.7}, 0.0);
          face(at, {0, kSiteStorey, 0}, (0.3 * kBay) * b.along, back);
          layout_.style({P::tiles, {0.14, 0.17, 0.22}, {0.80, 0.80, 0.78}, 1.4}, -0.15);
          face(at + (0.3 * kBay) * b.along, {0, kSiteStorey, 0}, (0.7 * kBay) * b.along, back);
          layout_.style({P::plain, {0.74, 0.73, 0.70}, {0.64, 0.63, 0.60}, 0.6}, -0.1);  // a wall between balconies
          const V wall = top + edge + (bay * kBay) * b.along;
          turned_box(wall + V(0, kSiteStorey, 0) + (back ? -1.8 : 0.0) * b.deep, 0.25 * b.along, 1.8 * b.deep,
                     kSiteStorey);
        }
      }
      layout_.style({P::plain, {0.52, 0.50, 0.47}, {0.44, 0.42, 0.40}, 0.8}, 0.9);  // what lies inside
      layout_.quad(floor, a, d, 4.0);
      for (int wall = 1; wall < b.bays; ++wall) {
        layout_.quad(top + (wall * kBay) * b.along, {0, kSiteStorey, 0}, d, 4.0);
      }
    }
    layout_.style({P::plain, {0.75, 0.74, 0.71}, {0.63, 0.62, 0.59}, 0.8}, 0.0);  // ends, roof and structures on it
    const V up(0, -height - 0.8, 0);
    layout_.quad(b.corner + up, d, -up, 3.0);
    layout_.quad(b.corner + a + up, -up, d, 3.0);
    layout_.style({P::mottled, {0.50, 0.50, 0.49}, {0.38, 0.38, 0.38}, 1.5}, 0.1);
    layout_.quad(b.corner + V(0, -height, 0), a, d, 3.0);
    layout_.style({P::plain, {0.72, 0.71, 0.69}, {0.60, 0.59, 0.57}, 0.6}, -0.1);
    for (const V& edge : {V(0.0), 0.97 * d}) turned_box(b.corner + edge - V(0, height, 0), a, 0.03 * d, 0.8);
    for (int i = 1; i < b.bays; i += 2) {
      turned_box(b.corner + (i * kBay) * b.along + 0.35 * d - V(0, height, 0), 2.5 * b.along, 3.0 * b.deep, 2.2);
    }
  }

  /// A face that looks out of the front, or of the back.
  void face(const V& origin, const V& down, const V& along, bool back) {
    if (back) {
      layout_.quad(origin, along, down, 3.0);
    } else {
      layout_.quad(origin, down, along, 3.0);
    }
  }

  /// Low white cubes with pools on their roofs.
  void white_house(const V& foot) {
    const V sizes[] = {{9, 7, 8}, {7, 5, 10}, {8, 9, 6}};
    const V places[] = {{-3, 0, 0}, {6, 0, 3}, {13, 0, -4}};
    for (int i = 0; i < 3; ++i) {
      const V at = foot + places[i];
      layout_.style({P::tiles, {0.90, 0.90, 0.88}, {0.55, 0.58, 0.62}, 2.4}, -0.1);
      layout_.box(at, sizes[i]);
      layout_.style({P::plain, {0.80, 0.79, 0.76}, {0.72, 0.71, 0.68}, 0.6}, -0.1);
      for (const double side : {-0.5, 0.5}) {
        layout_.box(at + V(side * sizes[i].x, -sizes[i].y, 0), {0.4, 0.7, sizes[i].z});
        layout_.box(at + V(0, -sizes[i].y, side * sizes[i].z), {sizes[i].x, 0.7, 0.4});
      }
      layout_.style({P::mottled, {0.08, 0.38, 0.72}, {0.20, 0.55, 0.85}, 1.0}, -0.1);  // water
      const V corner = at + V(-0.38 * sizes[i].x, -sizes[i].y - 0.3, -0.38 * sizes[i].z);
      layout_.quad(corner, {0.76 * sizes[i].x, 0, 0}, {0, 0, 0.76 * sizes[i].z}, 3.0);
    }
    layout_.style({P::plain, {0.70, 0.70, 0.70}, {0.56, 0.56, 0.57}, 0.5}, -0.1);  // tanks
    for (int i = 0; i < 3; ++i) layout_.cylinder(foot + V(-8.0, 0, 3.0 * i), foot + V(-8.0, -5.5, 3.0 * i), 1.2);
  }

  /// A lecture theatre of eight sides.
  void octagon(const V& foot) {
    constexpr double kHalf = 6.5;
    constexpr double kSide = 2.0 * kHalf * 0.41421356;
    const V corners[] = {{-0.5 * kSide, 0, -kHalf}, {0.5 * kSide, 0, -kHalf}, {kHalf, 0, -0.5 * kSide},
                         {kHalf, 0, 0.5 * kSide},   {0.5 * kSide, 0, kHalf},  {-0.5 * kSide, 0, kHalf},
                         {-kHalf, 0, 0.5 * kSide},  {-kHalf, 0, -0.5 * kSide}};
    const V up(0, -7.0, 0);
    layout_.style({P::stripes, {0.70, 0.68, 0.65}, {0.60, 0.58, 0.55}, 2.2}, 0.0);
    for (int i = 0; i < 8; ++i) {
      const V& from = corners[i];
      layout_.quad(foot + from + up, -up, corners[(i + 1) % 8] - from, 3.0);
    }
    layout_.style({P::mottled, {0.58, 0.57, 0.55}, {0.46, 0.45, 0.44}, 1.5}, 0.0);
    layout_.ellipsoid(foot + up, {kHalf, 0.9, kHalf});
  }

  void small_house(const V& foot, int number) {
    layout_.style({P::plain, {0.86, 0.84, 0.78}, {0.76, 0.73, 0.67}, 0.6}, 0.2);
    layout_.box(foot, {7.0, 3.2, 5.0});
    layout_.style({P::stripes, number % 2 == 0 ? V(0.55, 0.24, 0.16) : V(0.40, 0.38, 0.38), {0.34, 0.18, 0.14}, 0.6},
                  0.1);
    layout_.quad(foot + V(-3.8, -3.0, -2.9), {7.6, 0, 0}, {0, -1.8, 2.9}, 3.0);
    layout_.quad(foot + V(-3.8, -4.8, 0), {7.6, 0, 0}, {0, 1.8, 2.9}, 3.0);
  }

  void car(const V& foot, int number) {
    const V paints[] = {
        {0.75, 0.12, 0.10}, {0.90, 0.90, 0.90}, {0.12, 0.14, 0.18}, {0.20, 0.35, 0.65}, {0.85, 0.65, 0.12}};
    layout_.style({P::plain, paints[number % 5], 0.85 * paints[number % 5], 0.5}, -0.5);
    layout_.box(foot - V(0, 0.35, 0), {4.2, 0.75, 1.8});
    layout_.style({P::plain, {0.10, 0.12, 0.15}, {0.20, 0.23, 0.27}, 0.3}, -0.5);
    layout_.box(foot - V(0.2, 1.1, 0), {2.2, 0.6, 1.6});
  }

  void tree(const V& foot, double height, std::uint64_t number) {
    CounterRandom random(7, 0x7ee, number);
    layout_.style({P::mottled, {0.34, 0.26, 0.19}, {0.22, 0.16, 0.11}, 0.3}, -0.2).grain = {0, -1, 0};
    layout_.cylinder(foot, foot - V(0, 0.6 * height, 0), 0.03 * height);
    const double tone = random.uniform();
    for (int i = 0; i < 4; ++i) {
      const double out = random.uniform(0.05, 0.2);
      const double up = random.uniform(0.62, 0.85);
      const V at = foot - V(0, up * height, 0) + out * height * random.direction();
      layout_.style({P::mottled, {0.10 + 0.12 * tone, 0.24, 0.07}, {0.26 + 0.2 * tone, 0.42, 0.13}, 0.8}, 0.0);
      layout_.leaves(at, V(0.22, 0.17, 0.22) * height, 0.22);
    }
  }

  SynthLayout& layout_;
};

}  // namespace

SynthWorld building_world() {
  SynthWorld world;
  SiteBuilder(world.layout).build();
  world.statistics = whole_scene_statistics();
  world.statistics.size_mean = -0.55;
  world.statistics.size_sd = 0.5;
  world.statistics.haze_share = 0.0005;
  world.statistics.large_to_middle = {1.96, 0.36};
  world.statistics.middle_to_small = {1.88, 0.45};
  world.light = {-0.45, -0.8, -0.4};
  world.ambient = 0.55;
  world.middle = {0, -5, 0};
  world.diagonal = 100.0;
  world.cameras = {
      synth_camera("front", {-14, -24, -50}, {0, 2, -6}, 60), synth_camera("corner", {-40, -20, -30}, {-6, 2, 0}, 65),
      synth_camera("court", {36, -22, -14}, {8, 1, 9}, 65), synth_camera("high", {26, -42, -40}, {-2, 0, 0}, 55)};
  return world;
}

}  // namespace grtx::frontend
