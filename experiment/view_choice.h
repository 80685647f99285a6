// SPDX-License-Identifier: Apache-2.0
// Selects views of a camera file, and names the image files of a sequence.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "grtx/frontend/camera/camera.h"

namespace grtx {
class FilesRead;
}

namespace grtx::experiment {

struct ViewOptions {
  std::string cameras;     ///< file or COLMAP folder
  unsigned view = 0;       ///< index in the file
  std::string views;       ///< "A:B": a sequence instead of one view
  unsigned width = 0;      ///< pixels; 0: the file's
  unsigned height = 0;     ///< pixels; 0: the file's
  double fov_scale = 1.0;  ///< factor on the tangent of half the field of view
};

/// Loads the cameras, selects the view and applies the options. files: records the files opened. Throws Error if the
/// view does not exist.
frontend::Camera select_camera(const ViewOptions& view, FilesRead& files);
/// The same for `views`, one camera per frame; only `view` if `views` is "".
std::vector<frontend::Camera> select_cameras(const ViewOptions& view, FilesRead& files);
/// File of a frame of a sequence: `path` with _FRAME before its extension.
std::string frame_path(const std::string& path, std::size_t frame);
/// Files of all frames of `views`; only `path` if `views` is no sequence.
std::vector<std::string> frame_paths(const std::string& path, const std::string& views);

}  // namespace grtx::experiment
