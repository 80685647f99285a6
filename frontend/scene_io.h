// Reading scenes: the format is recognised from the content, not the file's name.
#pragma once

#include <string>

#include "frontend/scene.h"

namespace grtx::frontend {

/// INRIA .ply (binary or ASCII), PlayCanvas compressed .ply, .splat, .spz v1-v4. Throws Error{file, place, rule}.
Scene load_scene(const std::string& path);

}  // namespace grtx::frontend
