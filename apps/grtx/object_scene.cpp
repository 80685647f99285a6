#include "grtx/apps/grtx/object_scene.h"

#include <filesystem>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/base/progress.h"
#include "grtx/frontend/scene/scene_io.h"

namespace grtx::sim {

LoadedObjects load_objects(const std::string& path, FilesRead& files) {
  const frontend::ObjectList list = frontend::load_object_list(path, files);
  LoadedObjects objects;
  for (const std::string& file : list.files) objects.scenes.push_back(frontend::load_scene(file, {}, files));
  objects.placements = list.placements;
  return objects;
}

void find_files_of_scene(const std::string& path, FilesRead& files) {
  if (!frontend::is_object_list(path)) return frontend::find_scene_files(path, files);
  for (const std::string& file : frontend::load_object_list(path, files).files) {
    frontend::find_scene_files(file, files);
  }
}

frontend::Scene load_flat_scene(const std::string& path, FilesRead& files, bool quiet) {
  Progress progress("reading " + std::filesystem::path(path).filename().string(), 0, "", quiet);
  if (!frontend::is_object_list(path)) return frontend::load_scene(path, {}, files);
  LoadedObjects loaded = load_objects(path, files);
  // It does not matter from which structure the placements are taken.
  const frontend::MultiObjectWorld world(std::move(loaded.scenes), loaded.placements,
                                         {frontend::AccelKind::tlas_sphere, 6, false}, {});
  frontend::Scene scene = frontend::flatten(world, loaded.placements);
  scene.name = path;
  return scene;
}

const frontend::AccelerationStructure& build_view(frontend::ViewTracer& view, const frontend::AccelOptions& options,
                                                  bool quiet) {
  Progress progress("building " + frontend::accel_name(options.kind), 0, "", quiet);
  return view.build(options);
}

void add_flatten_option(CLI::App* command, bool& flatten) {
  command->add_flag("--flatten", flatten,
                    "Of an object list: all Gaussians in one scene, not three levels (default: off)");
}

void check_object_options(const std::string& path, const TracerCli& cli) {
  if (cli.secondary.what != "none") throw Error(path, "--secondary", "works on scenes of one object");
  if (cli.tracing != name_of(frontend::Tracing::multi)) {
    throw Error(path, "--tracing", "works on scenes of one object, but for multi");
  }
  if (cli.options.triangle_test == frontend::TriangleTest::world) {
    throw Error(path, "--triangle-test world", "works on scenes of one object");
  }
}

std::unique_ptr<frontend::ObjectViewTracer> object_view(const std::string& path, std::vector<frontend::Camera> cameras,
                                                        const TracerCli& cli, frontend::AccelKind accel,
                                                        FilesRead& files) {
  check_object_options(path, cli);
  LoadedObjects loaded = load_objects(path, files);
  return std::make_unique<frontend::ObjectViewTracer>(path, std::move(loaded.scenes), loaded.placements,
                                                      std::move(cameras), accel_options(cli, accel),
                                                      kernel_of(cli.kernel_radius, cli.kernel_degree));
}

}  // namespace grtx::sim
