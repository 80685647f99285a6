// SPDX-License-Identifier: Apache-2.0
// Small scenes for tests, made in memory, and a camera that looks at them.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/scene/scene.h"

namespace grtx::test {

struct RandomSceneOptions {
  std::size_t count = 300;
  double extent = 1.0;  ///< centres in a cube of this half edge
  double log_scale_mean = -2.5;
  double log_scale_sd = 1.0;
  double opacity_low = 0.02;
  double opacity_high = 0.95;
  unsigned sh_degree = 2;
};

inline frontend::Scene random_scene(unsigned seed, const RandomSceneOptions& o = {}) {
  std::mt19937 engine(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(engine()) / 4294967296.0);
  };
  // A statement a draw, the last component first: in which order a call's arguments are drawn is the compiler's choice.
  const auto normal = [&] {
    const double length = std::sqrt(-2.0 * std::log(uniform(1e-12, 1.0)));
    return length * std::cos(uniform(0.0, 6.283185307179586));
  };
  frontend::Scene scene;
  scene.sh_degree = o.sh_degree;
  scene.name = "random";
  for (std::size_t i = 0; i < o.count; ++i) {
    glm::vec3 mean, scale;
    float wxyz[4];
    for (int k = 2; k >= 0; --k) mean[k] = static_cast<float>(uniform(-o.extent, o.extent));
    for (int k = 2; k >= 0; --k) scale[k] = static_cast<float>(std::exp(o.log_scale_mean + o.log_scale_sd * normal()));
    for (int k = 3; k >= 0; --k) wxyz[k] = static_cast<float>(normal());
    scene.mean.push_back(mean);
    scene.scale.push_back(scale);
    scene.rotation.push_back(glm::normalize(glm::quat(wxyz[0], wxyz[1], wxyz[2], wxyz[3])));
    scene.opacity.push_back(static_cast<float>(uniform(o.opacity_low, o.opacity_high)));
    for (unsigned j = 0; j < 3 * scene.sh_coefficients(); ++j) {
      scene.sh.push_back(static_cast<float>(normal() * (j < 3 ? 0.8 : 0.15)));
    }
  }
  return scene;
}

/// Looks from (0, 0, -distance) along +z.
inline frontend::Camera front_camera(unsigned width, unsigned height, double distance = 4.0) {
  frontend::Camera camera{.name = "front", .width = width, .height = height, .position = {0.05, -0.03, -distance}};
  camera.fx = camera.fy = 0.9 * width;
  camera.cx = 0.5 * width;
  camera.cy = 0.5 * height;
  return camera;
}

}  // namespace grtx::test
