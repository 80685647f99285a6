#include "grtx/apps/grtx/scene_cli.h"

#include "grtx/base/error.h"

namespace grtx::sim {
namespace {

/// Throws Error for options that need a scene of one object.
void check_object_options(const std::string& path, const TracerCli& cli) {
  if (cli.secondary.what != "none") throw Error(path, "--secondary", "works on scenes of one object");
  if (cli.tracing != name_of(frontend::Tracing::multi)) {
    throw Error(path, "--tracing", "works on scenes of one object, but for multi");
  }
  if (cli.options.triangle_test == frontend::TriangleTest::world) {
    throw Error(path, "--triangle-test world", "works on scenes of one object");
  }
}

}  // namespace

void add_flatten_option(CLI::App* command, bool& flatten) {
  command->add_flag("--flatten", flatten,
                    "Of an object list: all Gaussians in one scene, not three levels (default: off)");
}

void load_scene(frontend::SceneTracer& scene, const std::string& path, bool several_objects,
                const std::vector<frontend::Camera>& cameras, const TracerCli& cli, frontend::AccelKind accel,
                FilesRead& files, bool quiet) {
  const frontend::Kernel kernel = kernel_of(cli.kernel_radius, cli.kernel_degree);
  if (!several_objects) return scene.load(path, cameras, kernel, files, quiet);
  check_object_options(path, cli);
  scene.load_objects(path, cameras, accel_options(cli, accel), kernel, files);
}

frontend::TracedView trace_scene(frontend::SceneTracer& scene, const TracerCli& cli, bool checkpoint,
                                 frontend::AccelKind accel, const frontend::RenderOptions& render,
                                 const std::string& trace_file, const FilesRead& files) {
  scene.build(accel_options(cli, accel), render.quiet);
  std::map<std::string, std::string> inputs = option_inputs(cli, checkpoint, accel);
  if (frontend::ViewTracer* const view = scene.view()) {
    view->place(optical_objects(cli.secondary, view->scene(), view->camera()));
    inputs.merge(object_inputs(view->objects()));
  }
  inputs.merge(files.inputs());
  return scene.trace(tracer_options(cli, checkpoint, accel), render, trace_file, inputs);
}

}  // namespace grtx::sim
