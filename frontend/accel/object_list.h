// SPDX-License-Identifier: Apache-2.0
// The file that places several Gaussian objects in one scene.
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace grtx {
class FilesRead;
}

namespace grtx::frontend {

/// One object's place: world = scale * rotate * (file coordinates) + translate.
struct Placement {
  unsigned object = 0;  ///< index of its file
  glm::dvec3 translate{0.0};
  glm::dquat rotate{1.0, 0.0, 0.0, 0.0};  ///< unit
  double scale = 1.0;                     ///< > 0, the same along all axes
};

struct ObjectList {
  std::vector<std::string> files;  ///< each once
  std::vector<Placement> placements;
};

/// Whether the file name is that of an object list (.json) rather than of a scene.
bool is_object_list(const std::string& path);
/// JSON array of {"file", "translate": [x, y, z], "rotate": [w, x, y, z], "scale": s}; all but "file" are optional.
/// Files are relative to the list's folder. files: the list itself is noted there. Throws Error.
ObjectList load_object_list(const std::string& path, FilesRead& files);
/// The same without noting what was opened.
ObjectList load_object_list(const std::string& path);

}  // namespace grtx::frontend
