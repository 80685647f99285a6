// SPDX-License-Identifier: Apache-2.0
// Parts of a generated scene: surfaces, the statistics its Gaussians follow, light, background and views.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/synth/synth_surface.h"

namespace grtx::frontend {

/// A gamma distribution; mean = shape * scale.
struct SynthGamma {
  double shape = 1.0, scale = 1.0;
};

/// Statistics of trained scenes (docs/model/synthetic-scenes.md lists the measured values and their origin).
struct SynthStatistics {
  double density_sd = 0.45;                          ///< of ln d8 between patches; d8: distance to the 8th neighbour
  double size_mean = -0.4, size_sd = 0.6;            ///< of ln(largest scale / d8)
  double middle_follows = 0.8, small_follows = 0.5;  ///< share of ln(largest / d8) that the other two scales follow
  SynthGamma large_to_middle{2.2, 0.4};              ///< ln(largest / middle scale)
  SynthGamma middle_to_small{1.8, 1.0};              ///< ln(middle / smallest scale)
  double needle_share = 0.0;                         ///< share whose ln(middle / smallest) follows `needle` instead
  SynthGamma needle{0.85, 5.5};
  double smallest_scale = 4.5e-5;         ///< scene units; smaller ones are raised to it
  std::array<double, 10> opacity{};       ///< share of each tenth of [0, 1]
  double opacity_size_correlation = 0.0;  ///< correlation of the normal scores of opacity and size
  double clear_share = 0.0;               ///< share with opacity 1e-6
  double aligned_share = 0.65;            ///< share with the shortest axis in a tight cone about the normal
  double cone = 0.15;                     ///< standard deviation of the cone's tangents
  double thickness = 0.3;                 ///< standard deviation of the offset along the normal, in d8
  double reach = 0.25;                    ///< largest scale, in square roots of the patch's area
  double capture = 0.0;                   ///< ln d8 grows by this with ln of the distance from the nearest camera
  bool rims = false;                      ///< Gaussians end at the rims of rectangles, rods and objects
  double coincident_share = 0.0;          ///< share that copies another row's centre
  double haze_share = 0.01;               ///< share of rows in the layout's haze volumes
  std::array<double, 4> sh_rms{0.12, 0.27, 0.16, 0.1};  ///< noise of f_dc, rms of the coefficients of bands 1, 2, 3
};

struct SynthWorld {
  SynthLayout layout;
  SynthStatistics statistics;
  glm::dvec3 light{-0.4, -0.8, -0.45};  ///< towards the light
  double ambient = 0.6;                 ///< 0..1, the rest is diffuse
  bool background = false;              ///< sky shell and far outliers, as training leaves them in whole scenes
  glm::dvec3 middle{0.0};               ///< of the core box
  double diagonal = 1.0;                ///< of the core box, scene units
  std::vector<Camera> cameras;
};

SynthWorld hall_world();
SynthWorld building_world();
SynthWorld flat_world();
SynthWorld room_world();
SynthWorld garden_world();
SynthWorld object_world();

/// 128 x 128 pixels, y points down, horizontal angle in degrees. Convention right, down, forward.
Camera synth_camera(const std::string& name, glm::dvec3 eye, glm::dvec3 target, double angle);

}  // namespace grtx::frontend
