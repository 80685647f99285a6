// The dense_indoor preset: a block of small furnished rooms, three storeys of four by four, captured from inside. A ray
// ends at the first furniture or wall; behind it lies the rest of the block, which only the structure knows about.
// Units: metres; y points down.
#include <array>

#include "grtx/frontend/synth/synth_rooms.h"
#include "grtx/frontend/synth/synth_world.h"

namespace grtx::frontend {
namespace {

using V = glm::dvec3;
using P = SynthPattern;

constexpr int kRooms = 4;  ///< along x and along z
constexpr int kStoreys = 3;
constexpr double kRoomSide = 3.6;    ///< of a room, wall to wall
constexpr double kRoomHeight = 2.5;  ///< floor to ceiling
constexpr double kSlab = 0.45;       ///< of walls and slabs
constexpr double kRoomPitch = kRoomSide + kSlab;
constexpr double kStoreyPitch = kRoomHeight + kSlab;
constexpr double kRoomCell = kRoomSide;  ///< patches of walls and floors: whole ones, so that few Gaussians cover them

/// Colours and furniture are drawn here, so that no two rooms look alike; the block is the same for every seed.
class RoomBuilder {
 public:
  RoomBuilder(SynthLayout& layout, int x, int storey, int z)
      : layout_(layout),
        corner_(x * kRoomPitch, -storey * kStoreyPitch, z * kRoomPitch),
        random_(kWorldSeed, static_cast<std::uint64_t>(storey), static_cast<std::uint64_t>(x * kRooms + z)) {}

  void build() {
    shell();
    // Shelves along the walls of every room; what stands in the middle differs.
    shelf({0.45, 0, 2.0}, {0.5, 2.1, 2.4});
    shelf({2.3, 0, 0.45}, {2.2, 1.9, 0.5});
    switch (random_.bits() % 4) {
      case 0:
        library();
        break;
      case 1:
        bedroom();
        break;
      case 2:
        kitchen();
        break;
      default:
        living_room();
        break;
    }
  }

 private:
  static constexpr std::uint64_t kWorldSeed = 0xde45e;

  V at(const V& in_room) const { return corner_ + in_room; }
  V colour(double least, double most) {
    const double grey = random_.uniform(least, most);
    const double red = random_.uniform(-0.12, 0.12);
    const double blue = random_.uniform(-0.12, 0.12);
    return {grey + red, grey, grey + blue};
  }
  void style(P pattern, double size, double detail) {
    const V first = colour(0.25, 0.8);
    const V second = colour(0.2, 0.8);
    layout_.style({pattern, first, second, size}, detail);
  }
  void box(const V& foot, const V& size, bool bottom = false) { layout_.box(at(foot), size, bottom); }
  void shelf(const V& foot, const V& size) {
    const V wood = colour(0.2, 0.5);
    layout_.style({P::books, wood, V(1.0), 0.05}, -0.3);
    box(foot, size);
  }

  void shell() {
    style(P::planks, 0.14, 0.0);
    layout_.quad(at({0, 0, 0}), {kRoomSide, 0, 0}, {0, 0, kRoomSide}, kRoomCell);  // a x b = -y: up
    style(P::plain, 0.8, 0.2);
    layout_.quad(at({0, -kRoomHeight, 0}), {0, 0, kRoomSide}, {kRoomSide, 0, 0}, kRoomCell);
    style(P::stripes, 0.3, 0.1);
    const SynthOpening door{2.5, 3.3, 0.0, 2.0};
    const std::vector<SynthOpening> doors{door};
    const V x(1, 0, 0);
    const V z(0, 0, 1);
    wall_face(layout_, {at({0, 0, 0}), x, kRoomSide, kRoomHeight, {}, kRoomCell}, false);
    wall_face(layout_, {at({0, 0, kRoomSide}), x, kRoomSide, kRoomHeight, doors, kRoomCell}, true);
    wall_face(layout_, {at({0, 0, 0}), z, kRoomSide, kRoomHeight, {}, kRoomCell}, true);
    wall_face(layout_, {at({kRoomSide, 0, 0}), z, kRoomSide, kRoomHeight, doors, kRoomCell}, false);
  }
  void library() {
    shelf({1.6, 0, 2.0}, {0.5, 2.0, 1.8});
    shelf({2.6, 0, 1.7}, {0.5, 2.0, 1.4});
  }
  void bedroom() {
    style(P::mottled, 0.25, -0.1);
    box({2.2, -0.2, 2.2}, {1.7, 0.3, 1.9});
    layout_.ellipsoid(at({2.2, -0.55, 2.1}), {0.8, 0.14, 0.8});
    style(P::planks, 0.2, 0.0);
    box({1.0, 0, 3.2}, {1.2, 2.0, 0.6});
  }
  void kitchen() {
    style(P::planks, 0.12, -0.1);
    box({2.1, -0.7, 2.1}, {1.4, 0.06, 0.9}, true);
    for (const double px : {1.6, 2.6}) layout_.cylinder(at({px, 0, 2.1}), at({px, -0.7, 2.1}), 0.06);
    style(P::tiles, 0.2, 0.0);
    box({1.2, 0, 3.2}, {2.0, 0.9, 0.6});
    box({1.2, -1.4, 3.3}, {2.0, 0.7, 0.4}, true);
  }
  void living_room() {
    style(P::mottled, 0.1, -0.1);
    box({1.5, -0.1, 3.0}, {1.9, 0.35, 0.9});
    box({1.5, -0.1, 3.35}, {1.9, 0.8, 0.25});
    style(P::mottled, 0.2, -0.1);
    layout_.leaves(at({2.6, -1.1, 1.8}), {0.5, 0.6, 0.5}, 0.1);
    layout_.cylinder(at({2.6, 0, 1.8}), at({2.6, -0.6, 1.8}), 0.2);
  }

  SynthLayout& layout_;
  V corner_;
  SynthRandom random_;
};

}  // namespace

SynthWorld dense_indoor_world() {
  SynthWorld world;
  for (int storey = 0; storey < kStoreys; ++storey) {
    for (int x = 0; x < kRooms; ++x) {
      for (int z = 0; z < kRooms; ++z) RoomBuilder(world.layout, x, storey, z).build();
    }
  }
  const V size(kRooms * kRoomPitch - kSlab, kStoreys * kStoreyPitch - kSlab, kRooms * kRoomPitch - kSlab);
  world.middle = {0.5 * size.x, -0.5 * size.y, 0.5 * size.z};
  world.layout.style({P::mottled, {0.7, 0.66, 0.6}, {0.5, 0.48, 0.45}, 0.8}).opacity_shift = -2.0;
  world.layout.haze(world.middle, 0.5 * size);
  world.statistics = indoor_statistics();
  world.statistics.reach = 0.5;  // a coarse capture does not resolve furniture; from 300,000 rows on it hardly matters
  world.light = {0.25, -0.75, -0.6};
  world.ambient = 0.62;
  world.background = true;
  world.diagonal = 20.0;
  // One eye in each corner of the block, at the height of a person's: two upstairs that look down, two downstairs that
  // look up, each along the diagonal, so that the block lies behind whatever ends the ray.
  const double near = 1.1;  // from the corner's walls, clear of the shelves
  const double upstairs = -(kStoreys - 1) * kStoreyPitch - 1.6;
  const double downstairs = -1.0;
  world.cameras = {synth_camera("north_west_down", {near, upstairs, near}, {size.x, 0.0, size.z}, 50),
                   synth_camera("south_east_down", {size.x - near, upstairs, size.z - near}, {0.0, 0.0, 0.0}, 50),
                   synth_camera("north_east_up", {size.x - near, downstairs, near}, {0.0, -size.y, size.z}, 50),
                   synth_camera("south_west_up", {near, downstairs, size.z - near}, {size.x, -size.y, 0.0}, 50)};
  return world;
}

}  // namespace grtx::frontend
