// NeRF transforms.json: camera-to-world matrices in OpenGL axes and one field of view or focal length.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "grtx/frontend/camera/camera.h"

namespace grtx::frontend {

/// Keys of the file, which a frame may override: camera_angle_x (radians) or fl_x, fl_y; cx, cy; w, h (else the size of
/// the frame's PNG). Per frame: transform_matrix, file_path. Distortion other than zero is refused. files: takes the
/// headers of PNGs. Throws Error.
std::vector<Camera> read_transforms_json(const nlohmann::json& json, const std::string& file, FilesRead& files);

}  // namespace grtx::frontend
