// The rotations that a node of layout obb chooses from, and a ray in the frame of one of them.
// docs/model/node-image.md, "Layout obb", has the bound by which the rotated ray's boxes are widened.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>

#include "grtx/frontend/gaussian/slab_intersection.h"

namespace grtx::frontend {

/// Entry 0 is the identity. As many as DOBB-BVH (arXiv 2506.22849) has.
inline constexpr unsigned kOrientations = 104;
/// Entries of the matrices are multiples of 2^-10.
inline constexpr unsigned kOrientationFractionBits = 10;

/// Rows of a rotation: x in the world lies at (row 0 . x, row 1 . x, row 2 . x) of the frame. A row's length differs
/// from 1 by 2^-10 at most, which no box test depends on: the frame is that of the rows as they are.
using Orientation = std::array<glm::vec3, 3>;

/// Spread evenly: each is the one farthest from those before it, a box's 24 symmetries taken into account, among the
/// rotations whose quaternions have integer components of at most 3.
const std::array<Orientation, kOrientations>& orientations();

/// A ray in the frame of a node, for boxes that are not widened: its origin is moved against (near) and along (far) the
/// ray's direction on each axis, which widens every box by as much.
struct RotatedRay {
  float near_origin[3];
  float far_origin[3];
  float inverse[3];
  bool negative[3];
};

/// 2^-21 |o|_1 (1 + |d|_1 / |d_i|) for the least d_i that is not zero: what the ray alone asks of the widening.
inline float rotation_margin(const SlabRay& ray) {
  const float reach = (std::fabs(ray.origin.x) + std::fabs(ray.origin.y)) + std::fabs(ray.origin.z);
  const float length = (std::fabs(ray.direction.x) + std::fabs(ray.direction.y)) + std::fabs(ray.direction.z);
  float steepest = 0.0f;
  for (int axis = 0; axis < 3; ++axis) {
    const float inverse = std::fabs(ray.inverse[axis]);
    if (inverse < std::numeric_limits<float>::max()) steepest = std::max(steepest, inverse);
  }
  return reach * (1.0f / (1 << 21)) * (1.0f + length * steepest);
}

inline RotatedRay rotated(const SlabRay& ray, const Orientation& rows) {
  const float margin = rotation_margin(ray);
  RotatedRay result;
  for (unsigned axis = 0; axis < 3; ++axis) {
    const glm::vec3& row = rows[axis];
    const float origin = (row.x * ray.origin.x + row.y * ray.origin.y) + row.z * ray.origin.z;
    const float direction = (row.x * ray.direction.x + row.y * ray.direction.y) + row.z * ray.direction.z;
    const float inverse = safe_inverse(direction);
    result.inverse[axis] = inverse;
    result.negative[axis] = std::signbit(inverse);
    const float against = std::copysign(margin, inverse);
    result.near_origin[axis] = origin + against;
    result.far_origin[axis] = origin - against;
  }
  return result;
}

}  // namespace grtx::frontend
