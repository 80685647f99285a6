// Reading scenes: the format is recognised from the content, not the file's name.
#pragma once

#include <string>

#include "grtx/frontend/scene/scene.h"

namespace grtx::frontend {

struct SceneReadOptions {
  /// .spz files do not say which axes they use. false: right, up, back, as the format's own library writes, turned into
  /// the .ply axes (right, down, forward) on reading; true: already .ply axes, as splat-transform writes.
  bool spz_raw_axes = false;
};

/// INRIA .ply (binary or ASCII), PlayCanvas compressed .ply, .splat, .spz v1-v4. Throws Error{file, place, rule}.
Scene load_scene(const std::string& path);
Scene load_scene(const std::string& path, const SceneReadOptions& options);

}  // namespace grtx::frontend
