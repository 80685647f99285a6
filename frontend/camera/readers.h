// SPDX-License-Identifier: Apache-2.0
// Readers of camera files, and the check that every camera must pass.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "grtx/base/files_read.h"
#include "grtx/frontend/camera/camera.h"

namespace grtx::frontend {

// The cameras.json of 3DGS: an array of poses with the camera's centre and its camera-to-world rotation.

/// Keys of an entry: width, height, position[3], rotation[3][3] (rows; columns are right, down, forward), fx, fy.
/// Optional: img_name; cx, cy (default: the image's middle); projection "pinhole" or "fisheye"; fisheye_fov (radians,
/// for fisheye; fx and fy then are optional). Throws Error.
std::vector<Camera> read_cameras_json(const nlohmann::json& json, const std::string& file);

// NeRF transforms.json: camera-to-world matrices in OpenGL axes and one field of view or focal length.

/// Keys of the file, which a frame may override: camera_angle_x (radians) or fl_x, fl_y; cx, cy; w, h (else the size of
/// the frame's PNG). Per frame: transform_matrix, file_path. Distortion other than zero is refused. files: the headers
/// of PNGs are noted there. Throws Error.
std::vector<Camera> read_transforms_json(const nlohmann::json& json, const std::string& file, FilesRead& files);

// COLMAP's binary model: cameras.bin (intrinsics) and images.bin (poses).

/// `folder` or its sparse/0, sparse or 0 holds the two files. Sorted by image name. Camera models 0 to 6; distortion
/// parameters must be 0; OPENCV_FISHEYE becomes an equidistant fisheye. files: both are noted. Throws Error with the
/// byte.
std::vector<Camera> read_colmap(const std::string& folder, FilesRead& files);

// Requirements on every camera that enters the program, whatever file it comes from.

/// Throws Error{file, place, rule} unless width and height are 1 to 65536, every number is finite, focal lengths are
/// positive and the rotation is orthonormal within 1e-3 and not a mirror.
void check_camera(const Camera& camera, const std::string& file, const std::string& place);

}  // namespace grtx::frontend
