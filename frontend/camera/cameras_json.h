// The cameras.json of 3DGS: an array of poses with the camera's centre and its camera-to-world rotation.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "grtx/frontend/camera/camera.h"

namespace grtx::frontend {

/// Keys an entry: width, height, position[3], rotation[3][3] (rows; columns are right, down, forward), fx, fy.
/// Optional: img_name; cx, cy (default: the image's middle); projection "pinhole" or "fisheye"; fisheye_fov (radians,
/// for fisheye; fx and fy then are optional). Throws Error.
std::vector<Camera> read_cameras_json(const nlohmann::json& json, const std::string& file);

}  // namespace grtx::frontend
