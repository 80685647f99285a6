// SPDX-License-Identifier: Apache-2.0
// The straight pieces of the path that a camera ray takes through glass and mirrors. Plain double arithmetic (+ - * /
// and sqrt), so paths are the same on every host. Gaussians do not bend light: a path depends on the objects alone.
#pragma once

#include <glm/vec3.hpp>
#include <limits>

#include "grtx/frontend/optics/optical_objects.h"
#include "grtx/traces/event.h"

namespace grtx::frontend {

/// One piece: from the origin, along the direction, up to `limit`.
struct PathPiece {
  glm::dvec3 origin{0.0};
  glm::dvec3 direction{0.0};                               ///< as given for the camera ray, then of unit length
  double limit = std::numeric_limits<double>::infinity();  ///< parameter at which the next surface lies
  traces::RayKind kind = traces::RayKind::primary;         ///< type of the surface where it starts
  bool meets_surface() const { return limit < std::numeric_limits<double>::infinity(); }
};

class LightPath {
 public:
  /// objects (in the ray's coordinates) must outlive the path. An origin inside the sphere starts inside the glass.
  LightPath(const OpticalObjects& objects, const glm::dvec3& origin, const glm::dvec3& direction);

  const PathPiece& piece() const { return piece_; }
  unsigned bounces() const { return bounces_; }
  /// Advances to the piece behind the surface. False if there is none: no surface, or max_bounces met (then
  /// truncated()).
  bool advance();
  bool truncated() const { return truncated_; }

 private:
  enum class Surface { none, glass, mirror };

  void find_surface();
  void cross_glass(const glm::dvec3& point);
  void reflect(const glm::dvec3& normal);

  const OpticalObjects& objects_;
  PathPiece piece_;
  Surface next_ = Surface::none;  ///< where the piece ends
  Surface left_ = Surface::none;  ///< where the piece began; a flat or convex surface cannot be met again from outside
  bool inside_ = false;           ///< in the glass
  bool truncated_ = false;
  unsigned bounces_ = 0;
};

}  // namespace grtx::frontend
