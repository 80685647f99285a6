// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/secondary_settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "grtx/base/error.h"

namespace grtx::experiment {

using namespace frontend;

namespace {

bool has_glass(const SecondarySettings& settings) { return settings.what == "glass" || settings.what == "both"; }
bool has_mirror(const SecondarySettings& settings) { return settings.what == "mirror" || settings.what == "both"; }

}  // namespace

void check_secondary(const SecondarySettings& settings) {
  if (!settings.glass.empty() && !has_glass(settings)) throw Error("--glass", "", "needs --secondary glass or both");
  if (!settings.mirror.empty() && !has_mirror(settings)) {
    throw Error("--mirror", "", "needs --secondary mirror or both");
  }
}

OpticalObjects optical_objects(const SecondarySettings& settings, const Scene& scene, const Camera& camera) {
  check_secondary(settings);
  const bool glass = has_glass(settings), mirror = has_mirror(settings);
  OpticalObjects objects;
  if ((glass && settings.glass.empty()) || (mirror && settings.mirror.empty())) {
    objects = place_at_random(scene, camera, glass, mirror, settings.glass_index, settings.seed);
  }
  if (!settings.glass.empty()) {
    const auto& g = settings.glass;
    objects.glass = make_glass({g[0], g[1], g[2]}, g[3], settings.glass_index);
  }
  if (!settings.mirror.empty()) {
    const auto& m = settings.mirror;
    objects.mirror = make_mirror({m[0], m[1], m[2]}, {m[3], m[4], m[5]}, m[6], m[7]);
  }
  objects.max_bounces = settings.bounces;
  check_apart(objects);
  return objects;
}

std::map<std::string, std::string> secondary_inputs(const SecondarySettings& settings) {
  std::map<std::string, std::string> inputs = {{"secondary", settings.what}};
  if (settings.what == "none") return inputs;
  inputs["secondary_seed"] = std::to_string(settings.seed);
  inputs["secondary_bounces"] = std::to_string(settings.bounces);
  inputs["glass_index"] = fmt::format("{}", settings.glass_index);
  return inputs;
}

std::map<std::string, std::string> placed_inputs(const SecondarySettings& settings) {
  std::map<std::string, std::string> inputs;
  if (!settings.glass.empty()) inputs["placed_glass"] = fmt::format("{}", fmt::join(settings.glass, ","));
  if (!settings.mirror.empty()) inputs["placed_mirror"] = fmt::format("{}", fmt::join(settings.mirror, ","));
  return inputs;
}

std::map<std::string, std::string> object_inputs(const OpticalObjects& objects) {
  std::map<std::string, std::string> inputs;
  if (objects.glass) {
    const GlassSphere& g = *objects.glass;
    inputs["glass"] = fmt::format("{},{},{},{}", g.centre.x, g.centre.y, g.centre.z, g.radius);
  }
  if (objects.mirror) {
    const Mirror& m = *objects.mirror;
    inputs["mirror"] = fmt::format("{},{},{},{},{},{},{},{}", m.centre.x, m.centre.y, m.centre.z, m.normal.x,
                                   m.normal.y, m.normal.z, m.width, m.height);
  }
  return inputs;
}

std::string describe(const OpticalObjects& objects) {
  std::vector<std::string> parts;
  for (const auto& [name, place] : object_inputs(objects)) parts.push_back(fmt::format("--{} {}", name, place));
  return fmt::format("{}", fmt::join(parts, " "));
}

}  // namespace grtx::experiment
