// The whole way from the file of a scene, or of a list of objects, to images, counters and trace. It keeps what was
// traced last: reading and building take longer than a small view, and the next trace mostly needs the same.
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

/// The scene in this file; of an object list its Gaussians in one scene. files: takes what is opened. quiet: without
/// progress on stderr.
Scene load_flat_scene(const std::string& path, FilesRead& files, bool quiet);

/// Notes what a SceneTracer opens for this scene, in the same order.
void find_files_of_scene(const std::string& path, FilesRead& files);

/// Holds one scene and one structure at most: what the next trace has no use for is freed before anything is read or
/// built for it.
class SceneTracer {
 public:
  /// What was done so far.
  struct Work {
    std::uint64_t scenes_read = 0;
    std::uint64_t structures_built = 0;
  };

  /// Reads a scene to look at it from these cameras. It is the one that is kept when that is of the same path and
  /// kernel, and none of its files was touched since. files: takes what the scene was read from, in any case.
  void load(const std::string& path, const std::vector<Camera>& cameras, Kernel kernel, FilesRead& files, bool quiet);
  /// The same of several objects, whose structure is built with them and kept when its options are the same, too.
  void load_objects(const std::string& path, const std::vector<Camera>& cameras, const AccelOptions& accel,
                    Kernel kernel, FilesRead& files);

  /// What was loaded: a scene or, where that is nullptr, several objects.
  ViewTracer* view() { return view_.get(); }
  const ViewTracer* view() const { return view_.get(); }
  const MultiObjectWorld* world() const { return objects_ ? &objects_->world() : nullptr; }
  /// What rays are traced in: of one scene, after its build().
  TracedStructure structure() const;
  /// Of one scene, or of all placements.
  std::uint64_t gaussians() const { return view_ ? view_->scene().size() : world()->gaussians(); }

  /// Builds the structure, unless the last one is of these options; that of several objects is there.
  void build(const AccelOptions& accel, bool quiet);
  /// After build(): as ViewTracer::trace().
  TracedView trace(const TracerOptions& options, const RenderOptions& render, const std::string& trace_file,
                   const std::map<std::string, std::string>& inputs) const;

  const Work& work() const { return work_; }

 private:
  /// Whether the files of `path` are those that were read.
  bool is_of(const std::string& path) const;
  void clear();
  void note(const std::string& path, const FilesRead& files);

  std::unique_ptr<ViewTracer> view_;
  std::unique_ptr<ObjectViewTracer> objects_;
  std::string path_;
  FilesRead files_;                  ///< of what is kept
  std::vector<std::string> stamps_;  ///< of these files, as the system tells them
  Work work_;
};

}  // namespace grtx::frontend
