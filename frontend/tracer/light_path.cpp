// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tracer/light_path.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace grtx::frontend {

LightPath::LightPath(const OpticalObjects& objects, const glm::dvec3& origin, const glm::dvec3& direction)
    : objects_(objects) {
  piece_.origin = origin;
  piece_.direction = direction;
  if (objects.glass) {
    const glm::dvec3 from_centre = origin - objects.glass->centre;
    inside_ = glm::dot(from_centre, from_centre) < objects.glass->radius * objects.glass->radius;
  }
  find_surface();
}

void LightPath::find_surface() {
  piece_.limit = std::numeric_limits<double>::infinity();
  next_ = Surface::none;
  const glm::dvec3& d = piece_.direction;
  const double length2 = glm::dot(d, d);
  if (objects_.glass && (inside_ || left_ != Surface::glass)) {
    const GlassSphere& glass = *objects_.glass;
    // The hits are half a chord before and behind the foot of the perpendicular from the centre: no cancellation.
    const glm::dvec3 to_centre = glass.centre - piece_.origin;
    const double foot = glm::dot(to_centre, d) / length2;
    const glm::dvec3 off_axis = foot * d - to_centre;
    const double chord2 = glass.radius * glass.radius - glm::dot(off_axis, off_axis);
    const double half = std::sqrt(std::max(chord2, 0.0) / length2);
    if (inside_) {
      piece_.limit = std::max(foot + half, 0.0);  // rounding at grazing incidence
      next_ = Surface::glass;
    } else if (chord2 > 0.0 && foot - half > 0.0) {
      piece_.limit = foot - half;
      next_ = Surface::glass;
    }
  }
  if (objects_.mirror && !inside_ && left_ != Surface::mirror) {
    const Mirror& mirror = *objects_.mirror;
    const double slope = glm::dot(d, mirror.normal);
    if (slope == 0.0) return;
    const double t = glm::dot(mirror.centre - piece_.origin, mirror.normal) / slope;
    if (!(t > 0.0 && t < piece_.limit)) return;
    const glm::dvec3 at = piece_.origin + t * d - mirror.centre;
    if (std::fabs(glm::dot(at, mirror.right)) > 0.5 * mirror.width) return;
    if (std::fabs(glm::dot(at, mirror.up)) > 0.5 * mirror.height) return;
    piece_.limit = t;
    next_ = Surface::mirror;
  }
}

bool LightPath::advance() {
  if (next_ == Surface::none) return false;
  if (bounces_ == objects_.max_bounces) {
    truncated_ = true;
    return false;
  }
  ++bounces_;
  const glm::dvec3 point = piece_.origin + piece_.limit * piece_.direction;
  piece_.direction = glm::normalize(piece_.direction);
  if (next_ == Surface::mirror) {
    reflect(objects_.mirror->normal);
    piece_.kind = traces::RayKind::mirror;
  } else {
    cross_glass(point);
    piece_.kind = traces::RayKind::glass;
  }
  left_ = next_;
  piece_.origin = point;
  find_surface();
  return true;
}

void LightPath::reflect(const glm::dvec3& normal) {
  piece_.direction = glm::normalize(piece_.direction - 2.0 * glm::dot(piece_.direction, normal) * normal);
}

void LightPath::cross_glass(const glm::dvec3& point) {
  const GlassSphere& glass = *objects_.glass;
  const glm::dvec3 outward = glm::normalize(point - glass.centre);
  const glm::dvec3 normal = inside_ ? -outward : outward;  // against the ray
  const double ratio = inside_ ? glass.index : 1.0 / glass.index;
  const double cosine = std::clamp(-glm::dot(piece_.direction, normal), 0.0, 1.0);
  const double sine2 = ratio * ratio * (1.0 - cosine * cosine);
  if (sine2 > 1.0) {  // total internal reflection
    reflect(normal);
    return;
  }
  piece_.direction = glm::normalize(ratio * piece_.direction + (ratio * cosine - std::sqrt(1.0 - sine2)) * normal);
  inside_ = !inside_;
}

}  // namespace grtx::frontend
