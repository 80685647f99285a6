// SPDX-License-Identifier: Apache-2.0
// Optional triangle test (TriangleTest::world), in place of that in canonical_hit.h: a ray against the three stored
// fp32 vertices of a triangle leaf, as a ray tracing unit does it. Watertight test of Woop, Benthin and Wald (JCGT
// 2(1), 2013): the triangle is sheared into the ray's own frame, so that the two triangles of an edge compute its edge
// function from the same numbers and no ray slips between them. A ray exactly on an edge hits both: hits are doubled,
// never missed. Front faces only (counter-clockwise from outside).
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <glm/vec3.hpp>

namespace grtx::frontend {

/// A ray prepared for the test; made once per ray in world space, once per instance in object space.
class ShearedRay {
 public:
  ShearedRay() = default;
  /// direction: not zero; need not be of unit length, t counts in multiples of it.
  ShearedRay(const glm::vec3& origin, const glm::vec3& direction) : origin_(origin) {
    const float x = std::fabs(direction.x), y = std::fabs(direction.y), z = std::fabs(direction.z);
    z_ = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
    x_ = (z_ + 1) % 3;
    y_ = (x_ + 1) % 3;
    if (direction[z_] < 0.0f) std::swap(x_, y_);  // keeps the winding
    shear_x_ = direction[x_] / direction[z_];
    shear_y_ = direction[y_] / direction[z_];
    shear_z_ = 1.0f / direction[z_];
  }

  /// t > 0 at which the ray enters the front of triangle abc, if it does.
  std::optional<float> hit(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) const {
    const glm::vec3 ra = a - origin_, rb = b - origin_, rc = c - origin_;
    const float ax = ra[x_] - shear_x_ * ra[z_], ay = ra[y_] - shear_y_ * ra[z_];
    const float bx = rb[x_] - shear_x_ * rb[z_], by = rb[y_] - shear_y_ * rb[z_];
    const float cx = rc[x_] - shear_x_ * rc[z_], cy = rc[y_] - shear_y_ * rc[z_];
    float u = cx * by - cy * bx;
    float v = ax * cy - ay * cx;
    float w = bx * ay - by * ax;
    if (u == 0.0f || v == 0.0f || w == 0.0f) {  // products of fp32 are exact in double: the sign is then right
      u = edge(cx, by, cy, bx);
      v = edge(ax, cy, ay, cx);
      w = edge(bx, ay, by, ax);
    }
    if (u < 0.0f || v < 0.0f || w < 0.0f) return std::nullopt;  // outside, or a back face
    const float determinant = (u + v) + w;
    if (!(determinant > 0.0f)) return std::nullopt;  // seen edge-on, or no area
    const float az = shear_z_ * ra[z_], bz = shear_z_ * rb[z_], cz = shear_z_ * rc[z_];
    const float t = ((u * az + v * bz) + w * cz) / determinant;
    if (!(t > 0.0f && t < std::numeric_limits<float>::infinity())) return std::nullopt;
    return t;
  }

 private:
  static float edge(float p, float q, float r, float s) {
    return static_cast<float>(static_cast<double>(p) * static_cast<double>(q) -
                              static_cast<double>(r) * static_cast<double>(s));
  }

  glm::vec3 origin_{0.0f};
  int x_ = 0, y_ = 1, z_ = 2;
  float shear_x_ = 0.0f, shear_y_ = 0.0f, shear_z_ = 1.0f;
};

}  // namespace grtx::frontend
