#include "frontend/prepared_gaussians.h"

#include <algorithm>
#include <cmath>
#include <glm/mat3x3.hpp>

#include "frontend/gaussian_math.h"

namespace grtx::frontend {
namespace {

// World boxes are widened by this share of their largest coordinate (16 ulp) and of the scene's size: the hit function
// and the boxes round differently. docs/numerics.md measures that no hit is lost to it.
constexpr float kRelativeMargin = 1.0f / (1 << 20);
constexpr float kSceneMargin = 1.0f / (1 << 22);

glm::dmat3 rotation_matrix(const glm::quat& rotation) {
  glm::dquat q(static_cast<double>(rotation.w), static_cast<double>(rotation.x), static_cast<double>(rotation.y),
               static_cast<double>(rotation.z));
  return glm::mat3_cast(glm::normalize(q));
}

}  // namespace

PreparedGaussians::PreparedGaussians(const Scene& scene, bool adaptive_radius)
    : records_(scene.size()), to_world_(3 * scene.size()) {
  std::vector<float> distance(scene.size());
  for (std::size_t g = 0; g < scene.size(); ++g) {
    GaussianRecord& record = records_[g];
    const double kappa = kernel_radius(static_cast<double>(scene.opacity[g]), adaptive_radius);
    const glm::dmat3 r = rotation_matrix(scene.rotation[g]);
    record.mean = scene.mean[g];
    record.kappa2 = static_cast<float>(kappa * kappa);
    record.opacity = scene.opacity[g];
    for (int axis = 0; axis < 3; ++axis) {
      const double extent = kappa * static_cast<double>(scene.scale[g][axis]);
      // Column `axis` of R is the local axis in world space; glm matrices are column-major.
      record.to_unit[axis] = glm::vec3(r[axis] / extent);
      for (int row = 0; row < 3; ++row) {
        to_world_[3 * g + static_cast<std::size_t>(row)][axis] = static_cast<float>(r[axis][row] * extent);
      }
    }
    distance[g] = std::max({std::fabs(record.mean.x), std::fabs(record.mean.y), std::fabs(record.mean.z)});
  }
  if (!distance.empty()) {
    auto middle = distance.begin() + static_cast<std::ptrdiff_t>(distance.size() / 2);
    std::nth_element(distance.begin(), middle, distance.end());
    absolute_margin_ = *middle * kSceneMargin;
  }
}

Box PreparedGaussians::widened(Box box) const {
  box.inflate(box.largest_coordinate() * kRelativeMargin + absolute_margin_);
  return box;
}

Box PreparedGaussians::face_box(std::uint32_t g, const Proxy& proxy, unsigned face) const {
  if (proxy.is_sphere()) return instance_box(g, proxy, false);
  Box box;
  for (const std::uint16_t v : proxy.triangles()[face]) box.extend(to_world(g, proxy.vertices()[v]));
  return widened(box);
}

Box PreparedGaussians::instance_box(std::uint32_t g, const Proxy& proxy, bool corners) const {
  const glm::vec3* a = &to_world_[3 * static_cast<std::size_t>(g)];
  const glm::vec3& m = records_[g].mean;
  Box box;
  if (proxy.is_sphere()) {
    for (int i = 0; i < 3; ++i) {
      // In double: the squares of scales beyond 1e19 are no floats.
      const glm::dvec3 row(a[i]);
      const auto half = static_cast<float>(std::sqrt(row.x * row.x + row.y * row.y + row.z * row.z));
      box.lower[i] = m[i] - half;
      box.upper[i] = m[i] + half;
    }
  } else {
    for (const glm::vec3& v : proxy.vertices()) box.extend(to_world(g, v));
  }
  if (corners) {
    const float h = proxy.half_extent();
    for (int i = 0; i < 3; ++i) {
      const float half = h * (std::fabs(a[i].x) + std::fabs(a[i].y) + std::fabs(a[i].z));
      box.lower[i] = std::min(box.lower[i], m[i] - half);
      box.upper[i] = std::max(box.upper[i], m[i] + half);
    }
  }
  return widened(box);
}

}  // namespace grtx::frontend
