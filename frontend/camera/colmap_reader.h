// COLMAP's binary model: cameras.bin (intrinsics) and images.bin (poses).
#pragma once

#include <string>
#include <vector>

#include "grtx/frontend/camera/camera.h"

namespace grtx::frontend {

/// `folder` holds the two files, or its sparse/0, sparse or 0 does. Sorted by image name. Camera models 0 to 6;
/// distortion parameters must be 0; OPENCV_FISHEYE becomes an equidistant fisheye. files: takes the two. Throws Error
/// with the byte.
std::vector<Camera> read_colmap(const std::string& folder, FilesRead& files);

}  // namespace grtx::frontend
