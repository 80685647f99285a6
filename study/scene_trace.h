// A scene of one object or a list of them: loaded and traced as settings say.
#pragma once

#include <string>
#include <vector>

#include "grtx/base/files_read.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/tracer/scene_tracer.h"
#include "grtx/study/tracer_settings.h"

namespace grtx::sim {

/// Loads `path` for a structure of this kind. several_objects: as such, not in one scene. files: takes what is opened.
/// quiet: without progress on stderr. Throws Error, too, for options that need a scene of one object.
void load_scene(frontend::SceneTracer& scene, const std::string& path, bool several_objects,
                const std::vector<frontend::Camera>& cameras, const TracerSettings& settings, frontend::AccelKind accel,
                FilesRead& files, bool quiet);

/// Builds and traces what load_scene() has read for this structure. trace_file: "" writes none. files: all that was
/// read.
frontend::TracedView trace_scene(frontend::SceneTracer& scene, const TracerSettings& settings, bool checkpoint,
                                 frontend::AccelKind accel, const frontend::RenderOptions& render,
                                 const std::string& trace_file, const FilesRead& files);

}  // namespace grtx::sim
