// Glass, mirror and their placement on the command line, shared by `trace`, `run` and `reference`.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/optics/optical_objects.h"
#include "grtx/frontend/scene/scene.h"

namespace grtx::sim {

struct SecondaryCli {
  std::string what = "none";
  std::vector<double> glass;   ///< x, y, z, r
  std::vector<double> mirror;  ///< cx, cy, cz, nx, ny, nz, w, h
  double glass_index = 1.5;
  std::uint64_t seed = 1;
  unsigned bounces = 8;
};

void add_secondary_options(CLI::App* command, SecondaryCli& cli);
/// The objects asked for, in file coordinates; what has no place of its own gets one by the seed. Throws Error.
frontend::OpticalObjects optical_objects(const SecondaryCli& cli, const frontend::Scene& scene,
                                         const frontend::Camera& camera);
/// The options as text.
std::map<std::string, std::string> secondary_inputs(const SecondaryCli& cli);
/// Where --glass and --mirror put them, as text; empty for what the seed places.
std::map<std::string, std::string> placed_inputs(const SecondaryCli& cli);
/// Where the objects ended up, as text in the form that --glass and --mirror take; empty without objects.
std::map<std::string, std::string> object_inputs(const frontend::OpticalObjects& objects);
/// The same as one line for people.
std::string describe(const frontend::OpticalObjects& objects);

}  // namespace grtx::sim
