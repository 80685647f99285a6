// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/optics/optical_objects.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/frontend/numbers/counter_random.h"

namespace grtx::frontend {
namespace {

constexpr double kLowestIndex = 1.0, kHighestIndex = 4.0;  // vacuum to germanium in the infrared
constexpr double kSmallestOpacity = 0.1;                   // nearly invisible Gaussians do not count for a view's depth

bool finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

// Median depth along the camera's axis of the Gaussians whose centres it sees; their spread when it sees none.
double median_depth(const Scene& scene, const Camera& camera) {
  const glm::dvec3 eye = camera.position - scene.offset;
  const double tan_x = camera.fx > 0.0 ? 0.5 * camera.width / camera.fx : 1.0;
  const double tan_y = camera.fy > 0.0 ? 0.5 * camera.height / camera.fy : 1.0;
  std::vector<double> seen, all;
  for (std::size_t g = 0; g < scene.size(); ++g) {
    const glm::dvec3 to = glm::dvec3(scene.mean[g]) - eye;
    const double depth = glm::dot(to, camera.rotation[2]);
    all.push_back(glm::length(to));
    if (scene.opacity[g] < kSmallestOpacity || depth <= 0.0) continue;
    if (std::fabs(glm::dot(to, camera.rotation[0])) > tan_x * depth) continue;
    if (std::fabs(glm::dot(to, camera.rotation[1])) > tan_y * depth) continue;
    seen.push_back(depth);
  }
  std::vector<double>& depths = seen.empty() ? all : seen;
  if (depths.empty()) return 1.0;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return std::max(*middle, 1e-6);
}

// Distance of a point from the rectangle.
double distance_to(const Mirror& mirror, const glm::dvec3& point) {
  const glm::dvec3 to = point - mirror.centre;
  const double x = std::clamp(glm::dot(to, mirror.right), -0.5 * mirror.width, 0.5 * mirror.width);
  const double y = std::clamp(glm::dot(to, mirror.up), -0.5 * mirror.height, 0.5 * mirror.height);
  return glm::length(to - x * mirror.right - y * mirror.up);
}

}  // namespace

OpticalObjects OpticalObjects::relative_to(const glm::dvec3& offset) const {
  OpticalObjects moved = *this;
  if (moved.glass) moved.glass->centre -= offset;
  if (moved.mirror) moved.mirror->centre -= offset;
  return moved;
}

GlassSphere make_glass(const glm::dvec3& centre, double radius, double index) {
  if (!finite(centre)) throw Error("--glass", "x,y,z", "must be finite");
  if (!(radius > 0.0 && std::isfinite(radius))) throw Error("--glass", "r", "must be positive and finite");
  if (!(index >= kLowestIndex && index <= kHighestIndex)) throw Error("--glass-index", "", "must be 1 to 4");
  return {centre, radius, index};
}

Mirror make_mirror(const glm::dvec3& centre, const glm::dvec3& normal, double width, double height) {
  if (!finite(centre)) throw Error("--mirror", "cx,cy,cz", "must be finite");
  const double length = glm::length(normal);
  if (!(length > 0.0 && std::isfinite(length))) throw Error("--mirror", "nx,ny,nz", "must be a finite direction");
  if (!(width > 0.0 && std::isfinite(width) && height > 0.0 && std::isfinite(height))) {
    throw Error("--mirror", "w,h", "must be positive and finite");
  }
  Mirror mirror;
  mirror.centre = centre;
  mirror.normal = normal / length;
  const glm::dvec3 vertical = std::fabs(mirror.normal.y) > 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
  mirror.right = glm::normalize(glm::cross(vertical, mirror.normal));
  mirror.up = glm::cross(mirror.normal, mirror.right);
  mirror.width = width;
  mirror.height = height;
  return mirror;
}

void check_apart(const OpticalObjects& objects) {
  if (!objects.glass || !objects.mirror) return;
  if (distance_to(*objects.mirror, objects.glass->centre) <= objects.glass->radius) {
    throw Error("--mirror", "", "must not touch the glass sphere");
  }
}

OpticalObjects place_at_random(const Scene& scene, const Camera& camera, bool glass, bool mirror, double index,
                               std::uint64_t seed) {
  const double median = median_depth(scene, camera);
  const double half_x = camera.fx > 0.0 ? 0.5 * camera.width / camera.fx : 1.0;  // tangents of half the view
  const double half_y = camera.fy > 0.0 ? 0.5 * camera.height / camera.fy : 1.0;
  const double half = std::min(half_x, half_y);
  const glm::dvec3 right = camera.rotation[0], down = camera.rotation[1], forward = camera.rotation[2];
  const bool both = glass && mirror;
  OpticalObjects objects;
  for (std::uint64_t attempt = 0;; ++attempt) {
    CounterRandom random(seed, 0x6f626a, attempt);  // a stream of its own
    const double side = random.uniform() < 0.5 ? -1.0 : 1.0;
    // A place at `depth` whose object of half size `size` (in tangents) stays in its part of the picture.
    const auto place = [&](double depth, double size, double half_of_picture) {
      const double low = both ? size : size - half_x;  // with two objects: from the middle outwards
      const double high = half_x - size;
      const double x = low < high ? random.uniform(low, high) : 0.5 * (low + high);
      const double y = half_y > size ? random.uniform(size - half_y, half_y - size) : 0.0;
      return camera.position + depth * (forward + (both ? half_of_picture * x : x) * right + y * down);
    };
    objects = {};
    if (glass) {
      const double depth = median * random.uniform(0.3, 0.6);
      const double size = half * random.uniform(0.3, 0.42);
      objects.glass = make_glass(place(depth, size, side), depth * size, index);
    }
    if (mirror) {
      const double depth = median * random.uniform(0.3, 0.6);
      const double size = half * random.uniform(0.35, 0.45);
      const glm::dvec3 centre = place(depth, size, -side);
      const double turn = random.uniform(-0.7, 0.7), tilt = random.uniform(-0.2, 0.2);  // tangents
      const glm::dvec3 facing = glm::normalize(camera.position - centre);
      objects.mirror = make_mirror(centre, facing + turn * right + tilt * down, 2.0 * depth * size,
                                   2.0 * depth * size * random.uniform(0.7, 1.0));
    }
    const bool apart = !both || distance_to(*objects.mirror, objects.glass->centre) > 1.05 * objects.glass->radius;
    if (apart || attempt == 63) break;
  }
  check_apart(objects);
  return objects;
}

}  // namespace grtx::frontend
