#include "grtx/apps/grtx/kept_scene.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include "grtx/apps/grtx/object_scene.h"

namespace grtx::sim {
namespace {

/// What changes when a file is replaced or written. A change that it misses does no harm: a trace names the bytes that
/// it was made from, and who asked for it compares them.
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

}  // namespace

bool KeptScene::is_of(const std::string& path) const { return path == path_ && stamps_of(files_) == stamps_; }

void KeptScene::clear() {
  view_.reset();
  objects_.reset();
  path_.clear();
}

void KeptScene::note(const std::string& path, const FilesRead& files) {
  path_ = path;
  files_ = files;
  stamps_ = stamps_of(files);
  ++work_.scenes_read;
}

frontend::ViewTracer& KeptScene::view(const std::string& path, const std::vector<frontend::Camera>& cameras,
                                      frontend::Kernel kernel, FilesRead& files, bool quiet) {
  if (view_ != nullptr && view_->kernel() == kernel && is_of(path)) {
    view_->look(cameras);
  } else {
    clear();
    FilesRead read;
    view_ = std::make_unique<frontend::ViewTracer>(load_flat_scene(path, read, quiet), cameras, kernel);
    note(path, read);
  }
  files.add(files_);
  return *view_;
}

const frontend::AccelerationStructure& KeptScene::build(const frontend::AccelOptions& options, bool quiet) {
  const unsigned before = view_->structures_built();
  const frontend::AccelerationStructure& accel = build_view(*view_, options, quiet);
  work_.structures_built += view_->structures_built() - before;
  return accel;
}

frontend::ObjectViewTracer& KeptScene::objects(const std::string& path, const std::vector<frontend::Camera>& cameras,
                                               const TracerCli& cli, frontend::AccelKind accel, FilesRead& files) {
  check_object_options(path, cli);
  const frontend::Kernel kernel = kernel_of(cli.kernel_radius, cli.kernel_degree);
  if (objects_ != nullptr && objects_->kernel() == kernel && objects_->world().options() == accel_options(cli, accel) &&
      is_of(path)) {
    objects_->look(cameras);
  } else {
    clear();
    FilesRead read;
    objects_ = object_view(path, cameras, cli, accel, read);
    ++work_.structures_built;
    note(path, read);
  }
  files.add(files_);
  return *objects_;
}

}  // namespace grtx::sim
