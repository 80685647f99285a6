// SPDX-License-Identifier: Apache-2.0
// The reference's own path of light through glass and mirror; shares with the tracer the objects' description, no code.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "grtx/frontend/optics/optical_objects.h"

namespace grtx::frontend {

struct ReferencePiece {
  glm::dvec3 origin;
  glm::dvec3 direction;
  double length;  ///< in units of the direction; infinity for the last piece, unless the path was cut off
};

class ReferenceOptics {
 public:
  /// objects: file coordinates; offset: the scene's. Paths run in scene coordinates.
  ReferenceOptics(const OpticalObjects& objects, const glm::dvec3& offset) : objects_(objects), offset_(offset) {}

  /// All pieces, at most max_bounces + 1; the first begins at the camera.
  std::vector<ReferencePiece> path(const glm::dvec3& origin, const glm::dvec3& direction) const;

 private:
  OpticalObjects objects_;
  glm::dvec3 offset_;
};

}  // namespace grtx::frontend
