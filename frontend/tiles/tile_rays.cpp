// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tiles/tile_rays.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace grtx::frontend {
namespace {

glm::vec3 orthonormal(const glm::dvec3& candidate, const glm::dvec3& axis) {
  return glm::vec3(glm::normalize(candidate - glm::dot(candidate, axis) * axis));
}

}  // namespace

TileRays::TileRays(const Camera& camera, const glm::vec3& camera_origin, unsigned x, unsigned y)
    : origin(camera_origin) {
  unsigned some = 0;
  for (unsigned r = 0; r < kTileRays; ++r) {
    const unsigned i = x + tile_x(r), j = y + tile_y(r);
    if (i >= camera.width || j >= camera.height) continue;
    const glm::dvec3 d = camera.direction(i, j);
    if (d == glm::dvec3(0.0)) continue;  // the projection has no ray here
    rays[r] = TraceRay(origin, glm::vec3(d));
    pixel[r] = j * camera.width + i;
    live |= std::uint64_t{1} << r;
    some = r;
  }
  if (live == 0) return;
  for (int axis = 0; axis < 3; ++axis) {
    inverse_min[axis] = std::numeric_limits<float>::infinity();
    inverse_max[axis] = -std::numeric_limits<float>::infinity();
  }
  for (unsigned r = 0; r < kTileRays; ++r) {
    if ((live >> r & 1) == 0) rays[r] = rays[some];
    const TraceRay& ray = rays[r];
    for (int axis = 0; axis < 3; ++axis) {
      direction[axis][r] = ray.direction[axis];
      inverse[axis][r] = ray.slabs.inverse[axis];
      inverse_min[axis] = std::min(inverse_min[axis], ray.slabs.inverse[axis]);
      inverse_max[axis] = std::max(inverse_max[axis], ray.slabs.inverse[axis]);
    }
    inverse_length2[r] = ray.inverse_length2;
    const float row[8] = {ray.direction.x,     ray.direction.y,     ray.direction.z,     ray.inverse_length2,
                          ray.slabs.inverse.x, ray.slabs.inverse.y, ray.slabs.inverse.z, 0.0f};
    std::copy(row, row + 8, packed[r]);
  }
  bound(camera);
  find_grid(camera, x, y);
}

void TileRays::bound(const Camera& camera) {
  glm::dvec3 sum(0.0);
  for (const TraceRay& ray : rays) sum += glm::dvec3(ray.direction);
  if (!(glm::dot(sum, sum) > 1.0)) return;  // rays all around
  const glm::vec3 axis(glm::normalize(sum));
  const glm::dvec3 exact_axis(axis);
  const bool use_right = std::fabs(glm::dot(camera.rotation[0], exact_axis)) < 0.9;
  const glm::vec3 first = orthonormal(use_right ? camera.rotation[0] : camera.rotation[1], exact_axis);
  const glm::vec3 second(glm::cross(exact_axis, glm::dvec3(first)));
  double low[2] = {1e30, 1e30}, high[2] = {-1e30, -1e30};
  narrow = true;
  for (unsigned r = 0; r < kTileRays; ++r) {
    const glm::dvec3 d(rays[r].direction);
    const double depth = glm::dot(d, exact_axis);
    if (!(depth > 0.1)) {
      narrow = false;
      return;
    }
    const double at[2] = {glm::dot(d, glm::dvec3(first)) / depth, glm::dot(d, glm::dvec3(second)) / depth};
    u[r] = static_cast<float>(at[0]);
    v[r] = static_cast<float>(at[1]);
    extent2 = std::max({extent2, u[r] * u[r], v[r] * v[r]});
    for (int i = 0; i < 2; ++i) {
      low[i] = std::min(low[i], at[i]);
      high[i] = std::max(high[i], at[i]);
    }
  }
  for (int i = 0; i < 3; ++i) {
    frame[i][0] = axis[i];
    frame[i][1] = first[i];
    frame[i][2] = second[i];
    frame[i][3] = 0.0f;
  }
  for (int p = 0; p < 4; ++p) {
    const glm::dvec3 side(p < 2 ? first : second);
    const double edge = p % 2 == 0 ? low[p / 2] - 4.0 * kPlaneTilt : high[p / 2] + 4.0 * kPlaneTilt;
    const glm::dvec3 inward = p % 2 == 0 ? side - edge * exact_axis : edge * exact_axis - side;
    glm::vec3 plane(glm::normalize(inward));
    for (const TraceRay& ray : rays) {
      if (!(glm::dot(glm::dvec3(plane), glm::dvec3(ray.direction)) >= kPlaneTilt)) plane = glm::vec3(0.0f);
    }
    for (int i = 0; i < 3; ++i) planes[p][i] = plane[i];
  }
}

void TileRays::find_grid(const Camera& camera, unsigned x, unsigned y) {
  if (camera.projection != Projection::pinhole) return;
  constexpr double kMiddle = 0.5 * (kTileEdge - 1);
  const double middle[2] = {(x + kMiddle + 0.5 - camera.cx) / camera.fx, (y + kMiddle + 0.5 - camera.cy) / camera.fy};
  scale[0] = static_cast<float>(camera.fx);
  scale[1] = static_cast<float>(camera.fy);
  for (int i = 0; i < 3; ++i) {
    along[i] = static_cast<float>(camera.rotation[2][i]);
    across[i] = static_cast<float>(camera.rotation[0][i] - middle[0] * camera.rotation[2][i]);
    down[i] = static_cast<float>(camera.rotation[1][i] - middle[1] * camera.rotation[2][i]);
  }
  // A box's corners and its hits are known to 2^-19 of their distance.
  const double steepness = 1.0 + middle[0] * middle[0] + middle[1] * middle[1];
  margin = static_cast<float>(1.0 / 256 + steepness * std::max(camera.fx, camera.fy) / (1 << 17));
  grid = margin < 0.25f;
  for (unsigned r = 0; r < kTileRays && grid; ++r) {
    if ((live >> r & 1) == 0) continue;
    const glm::dvec3 d(rays[r].direction);
    const double depth = glm::dot(d, glm::dvec3(along[0], along[1], along[2]));
    const double i = glm::dot(d, glm::dvec3(across[0], across[1], across[2])) / depth * static_cast<double>(scale[0]);
    const double j = glm::dot(d, glm::dvec3(down[0], down[1], down[2])) / depth * static_cast<double>(scale[1]);
    const double off = std::max(std::fabs(i + kMiddle - tile_x(r)), std::fabs(j + kMiddle - tile_y(r)));
    grid = depth > 0.0 && off < 0.25 * static_cast<double>(margin);
  }
}

}  // namespace grtx::frontend
