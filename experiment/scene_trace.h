// SPDX-License-Identifier: Apache-2.0
// Loads and traces a scene, either of one object or a list of objects.
#pragma once

#include <string>
#include <vector>

#include "grtx/base/files_read.h"
#include "grtx/experiment/tracer_settings.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/tracer/scene_tracer.h"

namespace grtx::experiment {

/// Loads `path` for an acceleration structure of kind `accel`. several_objects: keep objects apart, do not merge them.
/// files: records the files opened. quiet: no progress on stderr. Throws Error if the scene cannot be read or an option
/// needs a scene of one object.
void load_scene(frontend::SceneTracer& scene, const std::string& path, bool several_objects,
                const std::vector<frontend::Camera>& cameras, const TracerSettings& settings, frontend::AccelKind accel,
                FilesRead& files, bool quiet);

/// Builds the structure of a scene from load_scene() and traces it. trace_file: "" writes no trace. files: all files
/// read.
frontend::TracedView trace_scene(frontend::SceneTracer& scene, const TracerSettings& settings, bool checkpoint,
                                 frontend::AccelKind accel, const frontend::RenderOptions& render,
                                 const std::string& trace_file, const FilesRead& files);

}  // namespace grtx::experiment
