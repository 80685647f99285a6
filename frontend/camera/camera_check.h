// What every camera that enters the program must satisfy, whatever file it comes from.
#pragma once

#include <string>

#include "grtx/frontend/camera/camera.h"

namespace grtx::frontend {

/// Throws Error{file, place, rule} unless width and height are 1 to 65536, every number is finite, focal lengths are
/// positive and the rotation is orthonormal within 1e-3 and no mirror.
void check_camera(const Camera& camera, const std::string& file, const std::string& place);

}  // namespace grtx::frontend
