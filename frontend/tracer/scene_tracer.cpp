// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tracer/scene_tracer.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <filesystem>
#include <utility>

#include "grtx/base/long_work.h"
#include "grtx/base/progress.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/accel/object_list.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/traces/instance_levels.h"

namespace grtx::frontend {
namespace {

/// File-system state that changes when a file is replaced or written. A missed change does no harm: a trace names the
/// bytes that it was made from, and its user compares them.
std::string stamp(const std::string& path) {
  struct stat s {};
  if (::stat(path.c_str(), &s) != 0) return "";
  return fmt::format("{} {} {} {}.{} {}.{}", s.st_dev, s.st_ino, s.st_size, s.st_mtim.tv_sec, s.st_mtim.tv_nsec,
                     s.st_ctim.tv_sec, s.st_ctim.tv_nsec);
}

std::vector<std::string> stamps_of(const FilesRead& files) {
  std::vector<std::string> stamps;
  for (const FilesRead::File& file : files.files()) stamps.push_back(stamp(file.path));
  return stamps;
}

/// The scenes of a list, by index.
std::vector<Scene> scenes_of(const ObjectList& list, FilesRead& files) {
  std::vector<Scene> scenes;
  for (const std::string& file : list.files) scenes.push_back(load_scene(file, {}, files));
  return scenes;
}

/// Time as measured with 400,000 Gaussians on one core: 2.2 us per primitive.
void say_estimate(AccelKind kind, std::size_t gaussians) {
  const Proxy proxy(proxy_of(kind));
  const std::size_t leaves = traces::is_two_level(kind) || proxy.is_sphere() ? 1 : proxy.faces();
  say_long_work(
      "structure",
      fmt::format("building {} of {:.3g} M Gaussians", accel_name(kind), 1e-6 * static_cast<double>(gaussians)),
      2.2e-6 * static_cast<double>(leaves * gaussians), bytes_to_build(kind, gaussians, leaves));
}

}  // namespace

Scene load_flat_scene(const std::string& path, FilesRead& files, bool quiet) {
  Progress progress("reading " + std::filesystem::path(path).filename().string(), 0, "", quiet);
  if (!is_object_list(path)) return load_scene(path, {}, files);
  const ObjectList list = load_object_list(path, files);
  // Any structure will do: only the placements are used.
  const MultiObjectWorld world(scenes_of(list, files), list.placements, {AccelKind::tlas_sphere, 6, false}, {});
  Scene scene = flatten(world, list.placements);
  scene.name = path;
  return scene;
}

void find_files_of_scene(const std::string& path, FilesRead& files) {
  if (!is_object_list(path)) return find_scene_files(path, files);
  for (const std::string& file : load_object_list(path, files).files) find_scene_files(file, files);
}

bool SceneTracer::is_of(const std::string& path) const { return path == path_ && stamps_of(files_) == stamps_; }

void SceneTracer::clear() {
  view_.reset();
  objects_.reset();
  path_.clear();
}

void SceneTracer::note(const std::string& path, const FilesRead& files) {
  path_ = path;
  files_ = files;
  stamps_ = stamps_of(files);
  ++work_.scenes_read;
}

void SceneTracer::load(const std::string& path, const std::vector<Camera>& cameras, Kernel kernel, FilesRead& files,
                       bool quiet) {
  if (view_ != nullptr && view_->kernel() == kernel && is_of(path)) {
    view_->look(cameras);
  } else {
    clear();
    FilesRead read;
    Scene scene = load_flat_scene(path, read, quiet);
    const Progress progress("preparing Gaussians", 0, "", quiet);
    view_ = std::make_unique<ViewTracer>(std::move(scene), cameras, kernel);
    note(path, read);
  }
  files.add(files_);
}

void SceneTracer::load_objects(const std::string& path, const std::vector<Camera>& cameras, const AccelOptions& accel,
                               Kernel kernel, FilesRead& files, bool quiet) {
  if (objects_ != nullptr && objects_->kernel() == kernel && world()->options() == accel && is_of(path)) {
    objects_->look(cameras);
  } else {
    clear();
    FilesRead read;
    const Progress progress("building " + accel_name(accel.kind), 0, "", quiet);
    const ObjectList list = load_object_list(path, read);
    objects_ = std::make_unique<ObjectViewTracer>(path, scenes_of(list, read), list.placements, cameras, accel, kernel);
    ++work_.structures_built;
    note(path, read);
  }
  files.add(files_);
}

TracedStructure SceneTracer::structure() const {
  return view_ ? TracedStructure(view_->scene(), view_->gaussians(), view_->accel()) : TracedStructure(*world());
}

void SceneTracer::build(const AccelOptions& accel, bool quiet) {
  if (view_ == nullptr) return;
  if (!quiet) say_estimate(accel.kind, view_->gaussians().size());
  Progress progress("building " + accel_name(accel.kind), 0, "", quiet);
  const unsigned before = view_->structures_built();
  view_->build(accel);
  work_.structures_built += view_->structures_built() - before;
}

TracedView SceneTracer::trace(const TracerOptions& options, const RenderOptions& render, const std::string& trace_file,
                              const std::map<std::string, std::string>& inputs) const {
  return view_ ? view_->trace(options, render, trace_file, inputs)
               : objects_->trace(options, render, trace_file, inputs);
}

std::uint64_t SceneTracer::gaussians() const { return view_ ? view_->scene().size() : world()->gaussians(); }

}  // namespace grtx::frontend
