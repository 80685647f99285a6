// SPDX-License-Identifier: Apache-2.0
// Reading scenes: the format is recognised from the content, not the file's name.
#pragma once

#include <string>

#include "grtx/frontend/scene/scene.h"

namespace grtx {
class FilesRead;
}

namespace grtx::frontend {

struct RawRows;

struct SceneReadOptions {
  /// .spz files do not say which axes they use. false: right, up, back, as the format's own library writes, turned into
  /// the .ply axes (right, down, forward) on reading; true: already .ply axes, as splat-transform writes.
  bool spz_raw_axes = false;
  /// Level of detail of a streamed SOG scene (lod-meta.json): 0 is the finest.
  unsigned sog_lod = 0;
};

/// The rows of a scene as its file stores them, before any is dropped or clamped. Formats: INRIA .ply (binary or
/// ASCII), PlayCanvas compressed .ply, .splat, .ksplat, .spz v1-v4, SOG v1 and v2 (archive, folder with meta.json or
/// lod-meta.json, or one of these files), .glb with KHR_gaussian_splatting, .usda. Throws Error{file, place, rule}.
RawRows load_rows(const std::string& path, const SceneReadOptions& options);
RawRows load_rows(const std::string& path, const SceneReadOptions& options, FilesRead& files);

Scene load_scene(const std::string& path);
Scene load_scene(const std::string& path, const SceneReadOptions& options);
/// files: every file that is opened is noted there.
Scene load_scene(const std::string& path, const SceneReadOptions& options, FilesRead& files);

/// Notes the files that load_scene(path, {}, files) opens, in the same order, without making a scene. Throws Error.
void find_scene_files(const std::string& path, FilesRead& files);

}  // namespace grtx::frontend
