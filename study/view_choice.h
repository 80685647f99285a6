// Which picture of which camera file, and the files of a sequence of pictures.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "grtx/base/files_read.h"
#include "grtx/frontend/camera/camera.h"

namespace grtx::sim {

struct ViewOptions {
  std::string cameras;     ///< file or COLMAP folder
  unsigned view = 0;       ///< index in the file
  std::string views;       ///< A:B: a sequence in place of one view
  unsigned width = 0;      ///< pixels; 0: the file's
  unsigned height = 0;     ///< pixels; 0: the file's
  double fov_scale = 1.0;  ///< factor on the tangent of half the field of view
};

/// Loads the cameras and applies the options. files: takes what is opened. Throws Error when the view does not exist.
frontend::Camera select_camera(const ViewOptions& view, FilesRead& files);
/// The same of `views`, if given: one camera a frame.
std::vector<frontend::Camera> select_cameras(const ViewOptions& view, FilesRead& files);
/// File of a frame of a sequence: `path` with the frame's number before its ending.
std::string frame_path(const std::string& path, std::size_t frame);
/// Names for all frames of `views`; `path` alone when that is none.
std::vector<std::string> frame_paths(const std::string& path, const std::string& views);

}  // namespace grtx::sim
