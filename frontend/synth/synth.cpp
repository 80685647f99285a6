// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/synth/synth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <iterator>
#include <limits>

#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"
#include "grtx/frontend/numbers/portable_math.h"
#include "grtx/frontend/scene/ply_writer.h"
#include "grtx/frontend/synth/synth_gaussians.h"
#include "grtx/frontend/synth/synth_stress.h"
#include "grtx/frontend/synth/synth_world.h"

namespace grtx::frontend {
namespace {

const std::string kStressPrefix = "stress-";

struct Preset {
  const char* name;
  SynthWorld (*world)();
};
constexpr Preset kPresets[] = {{"hall", hall_world},     {"building", building_world}, {"room", room_world},
                               {"object", object_world}, {"flat", flat_world},         {"garden", garden_world}};

void check(const SynthOptions& options) {
  const std::vector<std::string> known = synth_presets();
  if (std::find(known.begin(), known.end(), options.preset) == known.end()) {
    throw Error("preset", options.preset,
                fmt::format("is not known; the nearest name is {}", nearest_name(options.preset, known)));
  }
  if (options.sh_degree > 3) throw Error("SH degree", std::to_string(options.sh_degree), "must be 0 to 3");
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();  // Gaussians are numbered with 32 bits
  if (options.count == 0 || options.count >= kMost) {
    throw Error("count", std::to_string(options.count), fmt::format("must be 1 to {}", kMost - 1));
  }
}

}  // namespace

std::string synth_cameras_path(const std::string& path) {
  const bool ply = path.size() > 4 && path.compare(path.size() - 4, 4, ".ply") == 0;
  return (ply ? path.substr(0, path.size() - 4) : path) + ".cameras.json";
}

std::vector<std::string> synth_presets() {
  std::vector<std::string> names;
  for (const Preset& preset : kPresets) names.push_back(preset.name);
  for (const std::string& name : stress_names()) names.push_back(kStressPrefix + name);
  return names;
}

void synthesise(const SynthOptions& options, const std::string& path) {
  check(options);
  if (options.preset.rfind(kStressPrefix, 0) == 0) {
    const StressScene scene = stress_scene(options.preset.substr(kStressPrefix.size()), options);
    PlyWriter ply(path, scene.rows.size(), options.sh_degree);
    for (const PlyRow& row : scene.rows) ply.add(row);
    ply.commit();
    write_cameras_json(synth_cameras_path(path), scene.cameras);
    return;
  }
  const SynthWorld world = std::find_if(std::begin(kPresets), std::end(kPresets), [&](const Preset& p) {
                             return p.name == options.preset;
                           })->world();
  const SynthGaussians gaussians(world, options);
  PlyWriter ply(path, options.count, options.sh_degree);
  for (std::uint64_t i = 0; i < options.count; ++i) ply.add(gaussians.row(i));
  ply.commit();
  write_cameras_json(synth_cameras_path(path), world.cameras);
}

Camera synth_camera(const std::string& name, glm::dvec3 eye, glm::dvec3 target, double angle) {
  Camera camera;
  camera.name = name;
  camera.width = camera.height = 128;
  camera.position = eye;
  const glm::dvec3 forward = glm::normalize(target - eye);
  const glm::dvec3 up = std::abs(forward.y) < 0.999 ? glm::dvec3(0, -1, 0) : glm::dvec3(0, 0, 1);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, up));
  camera.rotation = glm::dmat3(right, glm::cross(forward, right), forward);
  const SineCosine half = portable_turn(angle / 720.0);  // of half the angle
  camera.fx = camera.fy = 64.0 * half.cosine / half.sine;
  camera.cx = camera.cy = 64.0;
  return camera;
}

}  // namespace grtx::frontend
