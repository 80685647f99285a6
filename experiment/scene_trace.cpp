// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/scene_trace.h"

#include "grtx/base/error.h"

namespace grtx::experiment {
namespace {

/// Throws Error for options that need a scene of one object.
void check_object_options(const std::string& path, const TracerSettings& settings) {
  if (settings.secondary.what != "none") throw Error(path, "--secondary", "works on scenes of one object");
  if (settings.tracing != name_of(frontend::Tracing::multi)) {
    throw Error(path, "--tracing", "works on scenes of one object, but for multi");
  }
  if (settings.options.colour == frontend::ColourPer::frame) {
    throw Error(path, "--colour frame",
                "works on scenes of one object: an object that is placed twice has two colours");
  }
  if (settings.options.triangle_test == frontend::TriangleTest::world) {
    throw Error(path, "--triangle-test world", "works on scenes of one object");
  }
}

}  // namespace

void load_scene(frontend::SceneTracer& scene, const std::string& path, bool several_objects,
                const std::vector<frontend::Camera>& cameras, const TracerSettings& settings, frontend::AccelKind accel,
                FilesRead& files, bool quiet) {
  const frontend::Kernel kernel = kernel_of(settings.kernel_radius, settings.kernel_degree);
  if (!several_objects) return scene.load(path, cameras, kernel, files, quiet);
  check_object_options(path, settings);
  scene.load_objects(path, cameras, accel_options(settings, accel), kernel, files, quiet);
}

frontend::TracedView trace_scene(frontend::SceneTracer& scene, const TracerSettings& settings, bool checkpoint,
                                 frontend::AccelKind accel, const frontend::RenderOptions& render,
                                 const std::string& trace_file, const FilesRead& files) {
  scene.build(accel_options(settings, accel), render.quiet);
  std::map<std::string, std::string> inputs = option_inputs(settings, checkpoint, accel);
  if (frontend::ViewTracer* const view = scene.view()) {
    view->place(optical_objects(settings.secondary, view->scene(), view->camera()));
    inputs.merge(object_inputs(view->objects()));
  }
  inputs.merge(files.inputs());
  return scene.trace(tracer_options(settings, checkpoint, accel), render, trace_file, inputs);
}

}  // namespace grtx::experiment
