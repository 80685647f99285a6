// glTF 2.0 whose points carry KHR_gaussian_splatting: binary (.glb), or JSON (.gltf) with its buffers inside or beside
// it.
#pragma once

#include <string>
#include <string_view>

#include "grtx/base/files_read.h"
#include "grtx/frontend/scene/scene_rows.h"

namespace grtx::frontend {

/// True when the bytes start like a .glb.
bool is_glb(std::string_view bytes);

/// True when the bytes are a JSON object that names an asset, as every .gltf does. A SOG's meta.json may, too: ask for
/// that first.
bool is_gltf(std::string_view bytes);

/// A scene as rows, and the buffers that lay in other files, in the order of reading, for the scene's hash.
struct GltfRows {
  RawRows rows;
  std::string beside;
};

/// bytes: a .glb or .gltf; buffers with a relative uri are beside `file`. All splat primitives of the file's scene, one
/// after the other, in the axes of a .ply: glTF's y points up, so positions, rotations and harmonics are turned by half
/// a turn about z, as PlayCanvas' tools do. Nodes may move and scale uniformly; a node that rotates is refused, because
/// its harmonics would have to be rotated, too. files: takes the buffers beside it. Throws Error{file, place, rule}.
GltfRows read_gltf(std::string_view bytes, const std::string& file, FilesRead& files);

}  // namespace grtx::frontend
