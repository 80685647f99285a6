// Object lists (--scene objects.json) on the command line.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "grtx/apps/grtx/tracer_cli.h"
#include "grtx/base/files_read.h"
#include "grtx/frontend/accel/object_list.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/scene/scene.h"
#include "grtx/frontend/tracer/view_tracer.h"

namespace grtx::sim {

/// The scenes of a list, by index, and where they stand.
struct LoadedObjects {
  std::vector<frontend::Scene> scenes;
  std::vector<frontend::Placement> placements;
};
/// files: takes the list and what it names.
LoadedObjects load_objects(const std::string& path, FilesRead& files);

/// The scene in this file; of an object list its Gaussians in one scene. files: takes what is opened. quiet: without
/// progress on stderr.
frontend::Scene load_flat_scene(const std::string& path, FilesRead& files, bool quiet);

/// The structure of a view. quiet: without progress on stderr.
const frontend::AccelerationStructure& build_view(frontend::ViewTracer& view, const frontend::AccelOptions& options,
                                                  bool quiet);

/// Notes what either opens for this scene, in the same order.
void find_files_of_scene(const std::string& path, FilesRead& files);

void add_flatten_option(CLI::App* command, bool& flatten);

/// Throws Error for options that need a scene of one object.
void check_object_options(const std::string& path, const TracerCli& cli);

/// Tracer of the object list at `path`. files: takes what is opened. Throws as check_object_options().
std::unique_ptr<frontend::ObjectViewTracer> object_view(const std::string& path, std::vector<frontend::Camera> cameras,
                                                        const TracerCli& cli, frontend::AccelKind accel,
                                                        FilesRead& files);

}  // namespace grtx::sim
