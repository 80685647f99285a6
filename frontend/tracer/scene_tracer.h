// SPDX-License-Identifier: Apache-2.0
// From the file of a scene, or of a list of objects, to images, counters and trace. Keeps what was traced last: reading
// and building take longer than a small view, and the next trace mostly needs the same.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "grtx/base/files_read.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/tracer/traced_structure.h"
#include "grtx/frontend/tracer/view_tracer.h"

namespace grtx::frontend {

/// The scene in this file, or the objects of an object list as one scene. files: opened files are noted there. quiet:
/// without progress on stderr.
Scene load_flat_scene(const std::string& path, FilesRead& files, bool quiet);

/// Notes the files that a SceneTracer opens for this scene, in the same order.
void find_files_of_scene(const std::string& path, FilesRead& files);

/// Holds at most one scene and one structure: frees what the next trace does not need before it reads or builds.
class SceneTracer {
 public:
  /// Work done so far.
  struct Work {
    std::uint64_t scenes_read = 0;
    std::uint64_t structures_built = 0;
  };

  /// Loads a scene to view it from these cameras. Reuses the last one if path and kernel are the same and none of its
  /// files has changed since. files: the scene's files are noted there in any case.
  void load(const std::string& path, const std::vector<Camera>& cameras, Kernel kernel, FilesRead& files, bool quiet);
  /// The same for several objects, whose structure is built with them and reused if its options are the same, too.
  void load_objects(const std::string& path, const std::vector<Camera>& cameras, const AccelOptions& accel,
                    Kernel kernel, FilesRead& files, bool quiet = true);

  /// The loaded scene; nullptr if several objects are loaded.
  ViewTracer* view() { return view_.get(); }
  const ViewTracer* view() const { return view_.get(); }
  const MultiObjectWorld* world() const { return objects_ ? &objects_->world() : nullptr; }
  /// The structure to trace in; for one scene, after build().
  TracedStructure structure() const;
  /// Number of Gaussians of the scene or of all placements.
  std::uint64_t gaussians() const;

  /// Builds the structure of a scene unless the last one has these options; that of several objects exists already.
  void build(const AccelOptions& accel, bool quiet);
  /// After build(): as ViewTracer::trace().
  TracedView trace(const TracerOptions& options, const RenderOptions& render, const std::string& trace_file,
                   const std::map<std::string, std::string>& inputs) const;

  const Work& work() const { return work_; }

 private:
  /// Whether `path` was loaded and its files have not changed.
  bool is_of(const std::string& path) const;
  void clear();
  void note(const std::string& path, const FilesRead& files);

  std::unique_ptr<ViewTracer> view_;
  std::unique_ptr<ObjectViewTracer> objects_;
  std::string path_;
  FilesRead files_;                  ///< of what is loaded
  std::vector<std::string> stamps_;  ///< file-system state of these files
  Work work_;
};

}  // namespace grtx::frontend
