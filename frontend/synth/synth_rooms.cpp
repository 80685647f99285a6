// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/synth/synth_rooms.h"

namespace grtx::frontend {

void wall_face(SynthLayout& layout, const SynthWall& wall, bool flip) {
  const auto part = [&](double from, double to, double bottom, double top) {
    if (to - from < 0.01 || top - bottom < 0.01) return;
    const glm::dvec3 corner = wall.start + from * wall.along - glm::dvec3(0, top, 0);
    const glm::dvec3 a = (to - from) * wall.along;
    const glm::dvec3 b(0, top - bottom, 0);
    if (flip) {
      layout.quad(corner, b, a, wall.cell);
    } else {
      layout.quad(corner, a, b, wall.cell);
    }
  };
  double at = 0.0;
  for (const SynthOpening& opening : wall.openings) {
    part(at, opening.from, 0.0, wall.height);
    part(opening.from, opening.to, 0.0, opening.bottom);
    part(opening.from, opening.to, opening.top, wall.height);
    at = opening.to;
  }
  part(at, wall.length, 0.0, wall.height);
}

SynthStatistics indoor_statistics() {
  SynthStatistics s;
  s.density_sd = 0.65;
  s.size_mean = -0.08;
  s.size_sd = 0.46;
  s.thickness = 0.45;
  s.middle_follows = 0.6;
  s.small_follows = 0.2;
  s.large_to_middle = {2.17, 0.36};
  s.middle_to_small = {1.67, 0.90};
  s.opacity = {0.212, 0.210, 0.135, 0.097, 0.067, 0.053, 0.041, 0.036, 0.033, 0.117};
  s.opacity_size_correlation = -0.25;
  s.coincident_share = 0.0002;
  s.haze_share = 0.004;
  return s;
}

SynthStatistics whole_scene_statistics() {
  SynthStatistics s;
  s.density_sd = 0.25;
  s.size_mean = -0.35;
  s.size_sd = 0.58;
  s.thickness = 0.35;
  s.capture = 1.0;
  s.rims = true;
  s.middle_follows = 0.7;
  s.small_follows = 0.4;
  s.large_to_middle = {2.0, 0.54};
  s.middle_to_small = {1.58, 0.71};
  s.opacity = {0.04, 0.05, 0.06, 0.07, 0.08, 0.09, 0.10, 0.11, 0.13, 0.27};
  s.opacity_size_correlation = -0.25;
  s.haze_share = 0.001;
  s.sh_rms = {0.05, 0.12, 0.08, 0.06};
  return s;
}

}  // namespace grtx::frontend
