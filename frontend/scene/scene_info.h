// SPDX-License-Identifier: Apache-2.0
// Figures printed by `grtx info`: counts, boxes, distributions, and what loading dropped, clamped or noticed.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "grtx/frontend/scene/scene.h"

namespace grtx::frontend {

/// A box in the file's coordinates, before recentring.
struct FileBox {
  glm::dvec3 low{0.0}, high{0.0};
};

inline constexpr std::array<double, 7> kInfoPercentiles{1, 10, 25, 50, 75, 90, 99};
using Percentiles = std::array<double, kInfoPercentiles.size()>;  ///< linear between neighbouring ranks; 0 when empty

struct SceneInfo {
  std::string name;
  std::string hash;
  std::uint64_t gaussians = 0;  ///< kept
  unsigned sh_degree = 0;
  glm::dvec3 offset{0.0};
  std::optional<FileBox> centres;        ///< of all centres; unset for an empty scene
  std::optional<FileBox> inner_centres;  ///< without the outer 0.1 % of centres on each axis (0.05 % at either end)
  std::optional<FileBox> extent;         ///< of all ellipsoids at 3 sigma
  Percentiles scale_max{}, scale_mid{}, scale_min{};  ///< of each Gaussian's sorted scales, scene units
  Percentiles scale_ratio{};                          ///< largest over smallest scale
  std::array<std::uint64_t, 10> opacity_tenths{};     ///< [0, .1), [.1, .2) ... [.9, 1]
  LoadReport report;
};

SceneInfo describe(const Scene& scene);

std::string to_text(const SceneInfo& info);
/// Schema "grtx.info/1".
std::string to_json(const SceneInfo& info);

}  // namespace grtx::frontend
