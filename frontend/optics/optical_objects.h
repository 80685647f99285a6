// SPDX-License-Identifier: Apache-2.0
// The objects that cause secondary rays: one sphere of glass and one rectangular mirror. Geometry only; the tracer
// (light_path.h) and the reference each intersect it with code of their own.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>

#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/scene/scene.h"

namespace grtx::frontend {

struct GlassSphere {
  glm::dvec3 centre{0.0};
  double radius = 1.0;
  double index = 1.5;  ///< refractive index, against 1 outside; crown glass
};

/// Reflects all light, from both sides.
struct Mirror {
  glm::dvec3 centre{0.0};
  glm::dvec3 normal{0.0, 0.0, 1.0};  ///< unit
  glm::dvec3 right{1.0, 0.0, 0.0};   ///< unit, along the width
  glm::dvec3 up{0.0, 1.0, 0.0};      ///< unit, along the height
  double width = 1.0, height = 1.0;
};

struct OpticalObjects {
  std::optional<GlassSphere> glass;
  std::optional<Mirror> mirror;
  unsigned max_bounces = 8;  ///< surfaces that the light of one pixel may meet; a pass through the sphere meets two

  bool empty() const { return !glass && !mirror; }
  /// The same objects relative to `offset` (a scene's), in the coordinates of its rays.
  OpticalObjects relative_to(const glm::dvec3& offset) const;
};

/// Throws Error for a radius, size or index out of range.
GlassSphere make_glass(const glm::dvec3& centre, double radius, double index);
/// `normal` of any length > 0. The width runs along the horizontal cross(y, normal), with z for y when the normal is
/// within 25 degrees of y. Throws Error for a zero normal or sizes that are not positive.
Mirror make_mirror(const glm::dvec3& centre, const glm::dvec3& normal, double width, double height);
/// Throws Error when the mirror cuts or lies in the glass: a path would then have to end in the middle of it.
void check_apart(const OpticalObjects& objects);

/// Glass and mirror at random places in front of the camera, wholly in view and apart from each other: at 0.3 to 0.6 of
/// the median depth of what the camera sees, the glass in one half of the picture and the mirror, turned by up to 35
/// degrees from facing the camera, in the other (a lone object lies anywhere). Depends on `seed`, scene and camera
/// alone.
OpticalObjects place_at_random(const Scene& scene, const Camera& camera, bool glass, bool mirror, double index,
                               std::uint64_t seed);

}  // namespace grtx::frontend
