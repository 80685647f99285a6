// Object lists (--scene objects.json) on the command line.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "grtx/apps/grtx/tracer_cli.h"
#include "grtx/frontend/accel/object_list.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/scene/scene.h"

namespace grtx::sim {

/// The scenes of a list, by index, and where they stand.
struct LoadedObjects {
  std::vector<frontend::Scene> scenes;
  std::vector<frontend::Placement> placements;
};
LoadedObjects load_objects(const std::string& path);

/// Throws Error when `path` is an object list: `command` works on scenes of one object.
void refuse_objects(const std::string& path, const std::string& command);

/// `grtx trace --no-trace` of an object list: image and counters.
int render_object_list(const std::string& scene, const frontend::Camera& camera, frontend::AccelKind accel,
                       const TracerCli& cli, bool checkpoint, const std::string& image, const std::string& statistics,
                       bool quiet);

}  // namespace grtx::sim
