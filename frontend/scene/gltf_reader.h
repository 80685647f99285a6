// Binary glTF 2.0 (.glb) whose points carry KHR_gaussian_splatting.
#pragma once

#include <string>
#include <string_view>

#include "grtx/frontend/scene/scene_rows.h"

namespace grtx::frontend {

/// True when the bytes start like a .glb.
bool is_glb(std::string_view bytes);

/// All splat primitives of the file's scene, one after the other, in the axes of a .ply: glTF's y points up, so
/// positions, rotations and harmonics are turned by half a turn about z, as PlayCanvas' tools do. Nodes may move and
/// scale uniformly; a node that rotates is refused, because its harmonics would have to be rotated, too. Throws
/// Error{file, place, rule}.
RawRows read_glb(std::string_view bytes, const std::string& file);

}  // namespace grtx::frontend
