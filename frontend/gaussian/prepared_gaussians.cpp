// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/gaussian/prepared_gaussians.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/mat3x3.hpp>
#include <limits>

#include "grtx/base/error.h"
#include "grtx/frontend/gaussian/gaussian_math.h"

namespace grtx::frontend {
namespace {

// World boxes are widened by this share of their largest coordinate (16 ulp) and of the scene's size, because the hit
// function and the boxes round differently. docs/model/numerics.md measures that no hit is lost.
constexpr float kRelativeMargin = 1.0f / (1 << 20);
constexpr float kSceneMargin = 1.0f / (1 << 22);

constexpr std::size_t kMostVertices = 42;  // of a proxy: the icosphere of 80 faces

glm::dmat3 rotation_matrix(const glm::quat& rotation) {
  glm::dquat q(static_cast<double>(rotation.w), static_cast<double>(rotation.x), static_cast<double>(rotation.y),
               static_cast<double>(rotation.z));
  return glm::mat3_cast(glm::normalize(q));
}

}  // namespace

PreparedGaussians::PreparedGaussians(const Scene& scene, Kernel kernel, bool quantised)
    : records_(scene.size()), to_world_(3 * scene.size()), quantised_(quantised) {
  if (quantised) {
    if (scene.size() > std::size_t{1} << QuantisedGaussian::kIdBits) {
      throw Error("--layout", "quantised", "numbers at most 2^26 Gaussians");
    }
    widths_ = LeafWidths::choose(scene);
    codes_ = HugePageVector<QuantisedGaussian>(scene.size());
  }
  std::vector<float> distance(scene.size());
  for (std::size_t g = 0; g < scene.size(); ++g) {
    if (!quantised || !set_quantised(g, scene, kernel)) set_whole(g, scene, kernel);
    const GaussianRecord& record = records_[g];
    distance[g] = std::max({std::fabs(record.mean.x), std::fabs(record.mean.y), std::fabs(record.mean.z)});
  }
  if (!distance.empty()) {
    auto middle = distance.begin() + static_cast<std::ptrdiff_t>(distance.size() / 2);
    std::nth_element(distance.begin(), middle, distance.end());
    absolute_margin_ = *middle * kSceneMargin;
  }
}

namespace {

/// A Gaussian with its maps in double.
struct ExactMaps {
  ExactMaps(const Scene& scene, std::size_t g, float opacity, const Kernel& kernel)
      : kappa(kernel_radius(static_cast<double>(opacity), kernel)),
        r(rotation_matrix(scene.rotation[g])),
        extent(kappa * glm::dvec3(scene.scale[g])),
        to_unit{r[0] / extent[0], r[1] / extent[1], r[2] / extent[2]} {}
  // Column `axis` of R is the local axis in world space; glm matrices are column-major.
  glm::dmat3 to_world() const { return {r[0] * extent[0], r[1] * extent[1], r[2] * extent[2]}; }

  double kappa;
  glm::dmat3 r;
  glm::dvec3 extent;
  glm::dvec3 to_unit[3];
};

}  // namespace

void PreparedGaussians::set_whole(std::size_t g, const Scene& scene, const Kernel& kernel) {
  const ExactMaps maps(scene, g, scene.opacity[g], kernel);
  records_[g].opacity = scene.opacity[g];
  records_[g].mean = scene.mean[g];
  records_[g].kappa2 = static_cast<float>(maps.kappa * maps.kappa);
  set_maps(g, maps.to_unit, maps.to_world());
}

bool PreparedGaussians::set_quantised(std::size_t g, const Scene& scene, const Kernel& kernel) {
  if (widths_.wide[g]) return false;
  const float opacity = QuantisedGaussian::nearest_opacity(scene.opacity[g]);
  const ExactMaps maps(scene, g, opacity, kernel);
  if (!QuantisedGaussian::holds(widths_.grid, scene.mean[g], maps.to_unit)) {
    widths_.set_wide(g);
    return false;
  }
  records_[g].opacity = opacity;
  records_[g].kappa2 = static_cast<float>(maps.kappa * maps.kappa);
  codes_[g] = QuantisedGaussian(widths_.grid, static_cast<std::uint32_t>(g), opacity, scene.mean[g], maps.to_unit);
  read_code(g);
  return true;
}

void PreparedGaussians::set_maps(std::size_t g, const glm::dvec3 (&to_unit)[3], const glm::dmat3& to_world) {
  for (int axis = 0; axis < 3; ++axis) {
    records_[g].to_unit[axis] = glm::vec3(to_unit[axis]);
    for (int row = 0; row < 3; ++row) {
      to_world_[3 * g + static_cast<std::size_t>(row)][axis] = static_cast<float>(to_world[axis][row]);
    }
  }
}

void PreparedGaussians::read_code(std::size_t g) {
  const QuantisedGaussian& code = codes_[g];
  records_[g].mean = code.mean(widths_.grid);
  const glm::dvec3 to_unit[3] = {code.row(0), code.row(1), code.row(2)};
  // Rows of a rotation, each divided by a length: still far from singular when rounded.
  set_maps(g, to_unit, glm::inverse(glm::transpose(glm::dmat3(to_unit[0], to_unit[1], to_unit[2]))));
}

float PreparedGaussians::margin_of(const Box& box) const {
  return box.largest_coordinate() * kRelativeMargin + absolute_margin_;
}

Box PreparedGaussians::widened(Box box) const {
  box.inflate(margin_of(box));
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
      // In double: squares of scales beyond 1e19 overflow fp32.
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

// A box whose x, y and z are processed in one vector.
struct PreparedGaussians::WideBox {
  static constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Float4 lower = {kInfinity, kInfinity, kInfinity, kInfinity};
  Float4 upper = {-kInfinity, -kInfinity, -kInfinity, -kInfinity};

  void extend(Float4 point) {
    lower = min(point, lower);
    upper = max(point, upper);
  }
  /// Widens it as widened() does and stores it.
  void put(PrimitiveBox& box, float absolute_margin) const {
    const Float4 reach = max(abs(lower), abs(upper));
    const float margin = std::max({reach[0], reach[1], reach[2]}) * kRelativeMargin + absolute_margin;
    store(&box, 0, lower - margin);  // the fourth lanes overwrite the numbers, which the caller sets
    store(&box, 1, upper + margin);
  }
};

// World positions of the proxy's vertices, with the same operations as to_world().
unsigned PreparedGaussians::write_vertices(std::size_t g, const Proxy& proxy, Float4* world) const {
  const glm::vec3* a = &to_world_[3 * g];
  const glm::vec3& m = records_[g].mean;
  const Float4 x = {a[0].x, a[1].x, a[2].x, 0}, y = {a[0].y, a[1].y, a[2].y, 0}, z = {a[0].z, a[1].z, a[2].z, 0};
  const Float4 mean = {m.x, m.y, m.z, 0};
  for (const glm::vec3& v : proxy.vertices()) *world++ = ((x * v.x + y * v.y) + z * v.z) + mean;
  return static_cast<unsigned>(proxy.vertices().size());
}

void PreparedGaussians::write_face_boxes(std::size_t begin, std::size_t end, const Proxy& proxy,
                                         PrimitiveBox* boxes) const {
  if (proxy.is_sphere()) {
    write_instance_boxes(begin, end, proxy, false, boxes);
    return;
  }
  assert(proxy.vertices().size() <= kMostVertices);
  std::array<Float4, kMostVertices> world;
  for (std::size_t g = begin; g < end; ++g) {
    write_vertices(g, proxy, world.data());
    for (const auto& [a, b, c] : proxy.triangles()) {
      WideBox box;
      box.extend(world[a]);
      box.extend(world[b]);
      box.extend(world[c]);
      box.put(*boxes++, absolute_margin_);
    }
  }
}

void PreparedGaussians::write_patch_boxes(std::size_t begin, std::size_t end, const Proxy& proxy,
                                          const FacePatches& patches, PrimitiveBox* boxes) const {
  assert(!proxy.is_sphere() && proxy.vertices().size() <= kMostVertices);
  std::array<Float4, kMostVertices> world;
  for (std::size_t g = begin; g < end; ++g) {
    write_vertices(g, proxy, world.data());
    for (const FacePatch& patch : patches.patches()) {
      WideBox box;
      for (const std::uint16_t v : patch.vertices) box.extend(world[v]);
      box.put(*boxes++, absolute_margin_);
    }
  }
}

void PreparedGaussians::write_instance_boxes(std::size_t begin, std::size_t end, const Proxy& proxy, bool corners,
                                             PrimitiveBox* boxes) const {
  assert(proxy.vertices().size() <= kMostVertices);
  std::array<Float4, kMostVertices> world;
  for (std::size_t g = begin; g < end; ++g) {
    if (proxy.is_sphere() || corners) {
      *boxes++ = PrimitiveBox(instance_box(static_cast<std::uint32_t>(g), proxy, corners));
      continue;
    }
    const unsigned vertices = write_vertices(g, proxy, world.data());
    WideBox box;
    for (unsigned i = 0; i < vertices; ++i) box.extend(world[i]);
    box.put(*boxes++, absolute_margin_);
  }
}

}  // namespace grtx::frontend
