// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/reference/reference_optics.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <limits>

namespace grtx::frontend {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Roots of the quadratic |o + t d - c|^2 = r^2 by the stable formula q = -(b + sign(b) sqrt(b^2 - a c)).
struct Roots {
  double near = kInfinity;
  double far = kInfinity;
};
Roots sphere_roots(const glm::dvec3& from_centre, const glm::dvec3& d, double radius) {
  const double a = glm::dot(d, d);
  const double b = glm::dot(from_centre, d);
  const double c = (glm::length(from_centre) - radius) * (glm::length(from_centre) + radius);
  const double discriminant = b * b - a * c;
  if (!(discriminant > 0.0)) return {};
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  return q < 0.0 ? Roots{q / a, c / q} : Roots{c / q, q / a};
}

// Solves for the rectangle's own coordinates: p + t d = centre + x right + y up.
double rectangle_parameter(const glm::dvec3& from_centre, const glm::dvec3& d, const Mirror& mirror) {
  const glm::dmat3 system(mirror.right, mirror.up, -d);
  const double determinant = glm::dot(system[0], glm::cross(system[1], system[2]));
  if (determinant == 0.0) return kInfinity;
  const double x = glm::dot(from_centre, glm::cross(system[1], system[2])) / determinant;
  const double y = glm::dot(system[0], glm::cross(from_centre, system[2])) / determinant;
  const double t = glm::dot(system[0], glm::cross(system[1], from_centre)) / determinant;
  const bool within = 2.0 * std::fabs(x) <= mirror.width && 2.0 * std::fabs(y) <= mirror.height;
  return within && t > 0.0 ? t : kInfinity;
}

}  // namespace

std::vector<ReferencePiece> ReferenceOptics::path(const glm::dvec3& origin, const glm::dvec3& direction) const {
  std::vector<ReferencePiece> pieces;
  ReferencePiece piece{origin, direction, kInfinity};
  bool in_glass = objects_.glass && glm::length(origin - (objects_.glass->centre - offset_)) < objects_.glass->radius;
  bool from_mirror = false, from_glass = false;
  for (;;) {
    const glm::dvec3 centre = objects_.glass ? objects_.glass->centre - offset_ : glm::dvec3(0.0);
    double to_glass = kInfinity, to_mirror = kInfinity;
    if (objects_.glass) {
      const Roots roots = sphere_roots(piece.origin - centre, piece.direction, objects_.glass->radius);
      if (in_glass) {
        to_glass = roots.far > 0.0 && roots.far < kInfinity ? roots.far : 0.0;
      } else if (!from_glass && roots.near > 0.0) {
        to_glass = roots.near;
      }
    }
    if (objects_.mirror && !from_mirror && !in_glass) {
      const glm::dvec3 from_centre = piece.origin - (objects_.mirror->centre - offset_);
      to_mirror = rectangle_parameter(from_centre, piece.direction, *objects_.mirror);
    }
    piece.length = std::fmin(to_glass, to_mirror);
    pieces.push_back(piece);
    if (piece.length == kInfinity || pieces.size() > objects_.max_bounces) return pieces;

    const glm::dvec3 at = piece.origin + piece.length * piece.direction;
    const glm::dvec3 incoming = piece.direction / glm::length(piece.direction);
    glm::dvec3 outgoing;
    from_mirror = to_mirror < to_glass;
    from_glass = !from_mirror;
    if (from_mirror) {
      // The component along the normal changes its sign.
      const glm::dvec3 across = glm::dot(incoming, objects_.mirror->normal) * objects_.mirror->normal;
      outgoing = (incoming - across) - across;
    } else {
      // Snell on the tangential component: its length is the sine of the angle.
      const glm::dvec3 normal = (at - centre) / glm::length(at - centre);
      const double along = glm::dot(incoming, normal);
      const glm::dvec3 tangent = incoming - along * normal;
      const glm::dvec3 bent = tangent * (in_glass ? objects_.glass->index : 1.0 / objects_.glass->index);
      const double sine2 = glm::dot(bent, bent);
      if (sine2 > 1.0) {
        outgoing = tangent - along * normal;  // total internal reflection
      } else {
        outgoing = bent + std::copysign(std::sqrt(1.0 - sine2), in_glass ? 1.0 : -1.0) * normal;
        in_glass = !in_glass;
      }
    }
    piece = {at, outgoing / glm::length(outgoing), kInfinity};
  }
}

}  // namespace grtx::frontend
