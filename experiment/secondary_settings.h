// SPDX-License-Identifier: Apache-2.0
// Options for glass and mirror objects, which cause secondary rays.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/optics/optical_objects.h"
#include "grtx/frontend/scene/scene.h"

namespace grtx::experiment {

struct SecondarySettings {
  std::string what = "none";
  std::vector<double> glass;   ///< x, y, z, r
  std::vector<double> mirror;  ///< cx, cy, cz, nx, ny, nz, w, h
  double glass_index = 1.5;
  std::uint64_t seed = 1;
  unsigned bounces = 8;
};

/// Throws Error for --glass or --mirror without a --secondary that has them.
void check_secondary(const SecondarySettings& settings);
/// The requested objects, in file coordinates; those without a position are placed by the seed. Throws Error for
/// impossible values.
frontend::OpticalObjects optical_objects(const SecondarySettings& settings, const frontend::Scene& scene,
                                         const frontend::Camera& camera);
/// The options as text, for trace headers.
std::map<std::string, std::string> secondary_inputs(const SecondarySettings& settings);
/// Values of --glass and --mirror as text; no entry for an object placed by the seed.
std::map<std::string, std::string> placed_inputs(const SecondarySettings& settings);
/// Final positions of the objects, as text in the form of --glass and --mirror; empty without objects.
std::map<std::string, std::string> object_inputs(const frontend::OpticalObjects& objects);
/// The same as a line of text for the user.
std::string describe(const frontend::OpticalObjects& objects);

}  // namespace grtx::experiment
