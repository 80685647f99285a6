// SPDX-License-Identifier: Apache-2.0
// Ray-box slabs in fp32, written so that they are monotone: if box A contains box B then A's interval contains B's,
// exactly, because every operation rounds monotonically. All pruning in the tracer rests on this property.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>
#include <limits>

namespace grtx::frontend {

struct Box {
  glm::vec3 lower{std::numeric_limits<float>::infinity()};
  glm::vec3 upper{-std::numeric_limits<float>::infinity()};

  void extend(const glm::vec3& p) {
    lower = glm::vec3(std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z));
    upper = glm::vec3(std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z));
  }
  void extend(const Box& b) {
    extend(b.lower);
    extend(b.upper);
  }
  float largest_coordinate() const {
    return std::max({std::fabs(lower.x), std::fabs(lower.y), std::fabs(lower.z), std::fabs(upper.x), std::fabs(upper.y),
                     std::fabs(upper.z)});
  }
  void inflate(float margin) {
    lower -= glm::vec3(margin);
    upper += glm::vec3(margin);
  }
};

/// 2 gamma(3) of fp32: Ize, "Robust BVH Ray Traversal", JCGT 2013; pbrt-v4.
inline constexpr float kSlabSlack = 2.0f * (3.0f * 5.9604645e-8f) / (1.0f - 3.0f * 5.9604645e-8f);

/// 1/d that never yields NaN against a finite difference: zero and denormal components become +-FLT_MAX.
inline float safe_inverse(float d) {
  const float inverse = 1.0f / d;
  if (std::fabs(inverse) <= std::numeric_limits<float>::max()) return inverse;
  return std::copysign(std::numeric_limits<float>::max(), d);
}

/// Origin, direction and its reciprocal of a ray for slab tests.
struct SlabRay {
  glm::vec3 origin{0.0f};
  glm::vec3 direction{0.0f};
  glm::vec3 inverse{0.0f};
  bool negative[3] = {false, false, false};

  SlabRay() = default;
  SlabRay(const glm::vec3& o, const glm::vec3& d)
      : origin(o), direction(d), inverse(safe_inverse(d.x), safe_inverse(d.y), safe_inverse(d.z)) {
    for (int i = 0; i < 3; ++i) negative[i] = std::signbit(inverse[i]);
  }
};

struct Interval {
  float enter = 0.0f;
  float exit = -1.0f;
  bool empty() const { return !(enter <= exit); }
};

/// Parameters at which the ray enters and leaves the box, without slack.
inline Interval slab_interval(const SlabRay& ray, const Box& box) {
  float enter = -std::numeric_limits<float>::infinity();
  float exit = std::numeric_limits<float>::infinity();
  for (int i = 0; i < 3; ++i) {
    const float near_bound = ray.negative[i] ? box.upper[i] : box.lower[i];
    const float far_bound = ray.negative[i] ? box.lower[i] : box.upper[i];
    enter = std::max(enter, (near_bound - ray.origin[i]) * ray.inverse[i]);
    exit = std::min(exit, (far_bound - ray.origin[i]) * ray.inverse[i]);
  }
  return {enter, exit};
}

/// The same, restricted to t >= 0 and widened by kSlabSlack: the traversal compares it with t_min and t_max.
inline Interval conservative_interval(const SlabRay& ray, const Box& box) {
  const Interval i = slab_interval(ray, box);
  return {std::max(i.enter, 0.0f) * (1.0f - kSlabSlack), i.exit * (1.0f + kSlabSlack)};
}

}  // namespace grtx::frontend
