// The scene that was traced last, and its structure: reading and building take longer than a small view, and the next
// trace mostly needs the same.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "grtx/apps/grtx/tracer_cli.h"
#include "grtx/base/files_read.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/tracer/view_tracer.h"

namespace grtx::sim {

/// Holds one scene and one structure at most: what the next trace has no use for is freed before anything is read or
/// built for it.
class KeptScene {
 public:
  /// What was done so far.
  struct Work {
    std::uint64_t scenes_read = 0;
    std::uint64_t structures_built = 0;
  };

  /// The tracer of a scene of one object, with these frames. It is the one that is kept when that is of the same path
  /// and kernel, and none of its files was touched since. files: takes what the scene was read from, in any case.
  frontend::ViewTracer& view(const std::string& path, const std::vector<frontend::Camera>& cameras,
                             frontend::Kernel kernel, FilesRead& files, bool quiet);
  /// The structure of that view.
  const frontend::AccelerationStructure& build(const frontend::AccelOptions& options, bool quiet);
  /// The same of an object list, whose structure is built with it. Errors as object_view().
  frontend::ObjectViewTracer& objects(const std::string& path, const std::vector<frontend::Camera>& cameras,
                                      const TracerCli& cli, frontend::AccelKind accel, FilesRead& files);

  const Work& work() const { return work_; }

 private:
  /// Whether the files of `path` are those that were read.
  bool is_of(const std::string& path) const;
  void clear();
  void note(const std::string& path, const FilesRead& files);

  std::unique_ptr<frontend::ViewTracer> view_;
  std::unique_ptr<frontend::ObjectViewTracer> objects_;
  std::string path_;
  FilesRead files_;                  ///< of what is kept
  std::vector<std::string> stamps_;  ///< of these files, as the system tells them
  Work work_;
};

}  // namespace grtx::sim
