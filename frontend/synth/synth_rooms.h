// SPDX-License-Identifier: Apache-2.0
// Shared by the worlds of rooms: wall faces with openings, furniture, and the statistics of trained indoor scenes.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "grtx/frontend/synth/synth_world.h"

namespace grtx::frontend {

/// A hole in a wall: [from, to] along it and [bottom, top] above the floor.
struct SynthOpening {
  double from, to, bottom, top;
};

struct SynthWall {
  glm::dvec3 start;  ///< at the floor
  glm::dvec3 along;  ///< unit
  double length, height;
  std::vector<SynthOpening> openings;  ///< in order along the wall
  double cell = 1.2;                   ///< approximate size of its patches
};

/// Adds one face of a wall, seen from the side to which `along` x down points; flip: from the other side.
void wall_face(SynthLayout& layout, const SynthWall& wall, bool flip);

/// Furnishes a living room of 5 m by 4.2 m whose corner is the origin.
void furnish_living_room(SynthLayout& layout);

/// Shapes and opacities as in an indoor walk-through capture of 12.0 M Gaussians (docs/model/synthetic-scenes.md).
SynthStatistics indoor_statistics();

/// Statistics of trained whole scenes of 0.8 to 1.5 M Gaussians: an exhibition hall and a building
/// (docs/model/synthetic-scenes.md).
SynthStatistics whole_scene_statistics();

}  // namespace grtx::frontend
