// SPDX-License-Identifier: Apache-2.0
// Statistics of a scene as docs/model/synthetic-scenes.md defines them, by brute force. For the acceptance tests.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <random>
#include <vector>

#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/scene/scene.h"

namespace grtx::frontend {

/// Value at `share` (0..1) of the sorted values.
inline double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

inline double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

inline double deviation(const std::vector<double>& values) {
  const double middle = mean(values);
  double sum = 0.0;
  for (const double value : values) sum += (value - middle) * (value - middle);
  return values.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(values.size()));
}

/// Eigenvalues in ascending order and the eigenvector of the smallest one, by Jacobi rotations.
struct Eigen3 {
  std::array<double, 3> values;
  glm::dvec3 smallest;
};

inline Eigen3 eigen(glm::dmat3 m) {
  glm::dmat3 v(1.0);
  for (int sweep = 0; sweep < 12; ++sweep) {
    for (int p = 0; p < 3; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        if (m[p][q] == 0.0) continue;
        const double angle = 0.5 * std::atan2(2.0 * m[p][q], m[q][q] - m[p][p]);
        glm::dmat3 r(1.0);
        r[p][p] = r[q][q] = std::cos(angle);
        r[q][p] = std::sin(angle);
        r[p][q] = -std::sin(angle);
        m = glm::transpose(r) * m * r;
        v = v * r;
      }
    }
  }
  std::array<int, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&](int a, int b) { return m[a][a] < m[b][b]; });
  return {{m[order[0]][order[0]], m[order[1]][order[1]], m[order[2]][order[2]]}, v[order[0]]};
}

struct RayStatistics {
  std::vector<double> boxes, ellipsoids, blended, box_per_ellipsoid;  ///< one entry a ray that meets a box
  double share_with_box = 0.0, share_ended = 0.0;
};

class SceneStatistics {
 public:
  explicit SceneStatistics(const Scene& scene) : scene_(scene) {
    std::array<std::vector<double>, 3> coordinates;
    for (std::size_t i = 0; i < scene.size(); ++i) {
      const glm::dmat3 r(glm::mat3_cast(glm::dquat(scene.rotation[i])));
      const glm::dvec3 s(scene.scale[i]);
      glm::dvec3 half(0.0);
      for (int k = 0; k < 3; ++k) half += r[k] * r[k] * (s[k] * s[k]);
      half_.push_back(3.0 * glm::sqrt(half));
      axes_.push_back(r);
      for (int k = 0; k < 3; ++k) coordinates[static_cast<std::size_t>(k)].push_back(scene.mean[i][k]);
    }
    glm::dvec3 size;
    for (std::size_t k = 0; k < 3; ++k) {
      size[static_cast<int>(k)] = percentile(coordinates[k], 0.95) - percentile(coordinates[k], 0.05);
    }
    diagonal_ = glm::length(size);
  }

  /// D: diagonal of the box of centres between the 5th and 95th percentile of each axis.
  double diagonal() const { return diagonal_; }

  /// Volume of the 3-sigma ellipsoid over the volume of its box, every Gaussian.
  std::vector<double> ellipsoid_per_box() const {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < scene_.size(); ++i) {
      const glm::dvec3 s(scene_.scale[i]);
      const double ellipsoid = 4.0 / 3.0 * 3.141592653589793 * 27.0 * s.x * s.y * s.z;
      ratios.push_back(ellipsoid / (8.0 * half_[i].x * half_[i].y * half_[i].z));
    }
    return ratios;
  }

  /// Share of all box surface area that the biggest `share` of the boxes hold.
  double area_share(double share) const {
    std::vector<double> areas;
    double total = 0.0;
    for (const glm::dvec3& h : half_) {
      areas.push_back(h.x * h.y + h.y * h.z + h.z * h.x);
      total += areas.back();
    }
    std::sort(areas.rbegin(), areas.rend());
    double sum = 0.0;
    const auto count = static_cast<std::size_t>(share * static_cast<double>(areas.size()));
    for (std::size_t i = 0; i < count; ++i) sum += areas[i];
    return sum / total;
  }

  struct Neighbourhood {
    std::vector<double> flatness;       ///< sqrt(smallest / largest eigenvalue) of the 16 nearest centres
    std::vector<double> normal_cosine;  ///< |cos| between the shortest axis and the normal of those 16
    std::vector<double> log_d8;         ///< ln(d8 / D)
    std::vector<double> log_size;       ///< ln(largest scale / d8)
  };

  Neighbourhood neighbourhood(std::size_t samples, unsigned seed) const {
    Neighbourhood result;
    std::mt19937 random(seed);
    std::vector<std::pair<double, std::size_t>> distance(scene_.size());
    for (std::size_t n = 0; n < samples; ++n) {
      const std::size_t i = random() % scene_.size();
      const glm::dvec3 centre(scene_.mean[i]);
      for (std::size_t j = 0; j < scene_.size(); ++j) {
        const glm::dvec3 d = glm::dvec3(scene_.mean[j]) - centre;
        distance[j] = {glm::dot(d, d), j};
      }
      std::nth_element(distance.begin(), distance.begin() + 16, distance.end());
      std::sort(distance.begin(), distance.begin() + 17);
      glm::dvec3 middle(0.0);
      for (int k = 1; k <= 16; ++k)
        middle += glm::dvec3(scene_.mean[distance[static_cast<std::size_t>(k)].second]) / 16.0;
      glm::dmat3 covariance(0.0);
      for (int k = 1; k <= 16; ++k) {
        const glm::dvec3 d = glm::dvec3(scene_.mean[distance[static_cast<std::size_t>(k)].second]) - middle;
        covariance += glm::outerProduct(d, d);
      }
      const Eigen3 shape = eigen(covariance);
      const glm::vec3 s = scene_.scale[i];
      const int shortest = s.x <= s.y && s.x <= s.z ? 0 : s.y <= s.z ? 1 : 2;
      const double d8 = std::sqrt(distance[8].first);
      if (!(d8 > 0.0)) continue;
      result.flatness.push_back(std::sqrt(std::max(0.0, shape.values[0]) / shape.values[2]));
      result.normal_cosine.push_back(std::abs(glm::dot(axes_[i][shortest], shape.smallest)));
      result.log_d8.push_back(std::log(d8 / diagonal_));
      result.log_size.push_back(std::log(static_cast<double>(std::max({s.x, s.y, s.z})) / d8));
    }
    return result;
  }

  struct Overlap {
    double boxes = 0.0, ellipsoids = 0.0;  ///< mean number that hold a point
  };

  /// At points drawn from random Gaussians of opacity >= 0.1.
  Overlap overlap(std::size_t samples, unsigned seed) const {
    Overlap result;
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    for (std::size_t n = 0; n < samples;) {
      const std::size_t i = random() % scene_.size();
      if (scene_.opacity[i] < 0.1f) continue;
      ++n;
      glm::dvec3 local;
      for (int k = 2; k >= 0; --k) local[k] = normal(random);  // a call's arguments have no order
      const glm::dvec3 point = glm::dvec3(scene_.mean[i]) + axes_[i] * (local * glm::dvec3(scene_.scale[i]));
      for (std::size_t j = 0; j < scene_.size(); ++j) {
        const glm::dvec3 d = glm::abs(point - glm::dvec3(scene_.mean[j]));
        if (d.x > half_[j].x || d.y > half_[j].y || d.z > half_[j].z) continue;
        result.boxes += 1.0 / static_cast<double>(samples);
        const glm::dvec3 q =
            glm::transpose(axes_[j]) * (point - glm::dvec3(scene_.mean[j])) / glm::dvec3(scene_.scale[j]);
        if (glm::dot(q, q) <= 9.0) result.ellipsoids += 1.0 / static_cast<double>(samples);
      }
    }
    return result;
  }

  /// 3-sigma boxes and ellipsoids along n x n rays of a view, whole rays; blended by peak until T < 0.001.
  RayStatistics rays(const Camera& view, unsigned n) const {
    RayStatistics result;
    const Camera camera = view.resized(n, n);
    const glm::dvec3 origin = camera.position - scene_.offset;
    for (unsigned y = 0; y < n; ++y) {
      for (unsigned x = 0; x < n; ++x) trace(origin, camera.direction(x, y), result);
    }
    const double all = static_cast<double>(n) * n;
    result.share_ended /= std::max(1.0, static_cast<double>(result.boxes.size()));
    result.share_with_box = static_cast<double>(result.boxes.size()) / all;
    return result;
  }

 private:
  void trace(const glm::dvec3& origin, const glm::dvec3& d, RayStatistics& result) const {
    double boxes = 0.0;
    std::vector<std::pair<double, double>> hits;  // peak t, alpha
    double ellipsoids = 0.0;
    for (std::size_t i = 0; i < scene_.size(); ++i) {
      const glm::dvec3 m = glm::dvec3(scene_.mean[i]) - origin;
      double enter = 0.0;
      double leave = 1e300;
      for (int k = 0; k < 3; ++k) {
        const double a = (m[k] - half_[i][k]) / d[k];
        const double b = (m[k] + half_[i][k]) / d[k];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
      }
      if (enter > leave) continue;
      ++boxes;
      const glm::dvec3 p = d * glm::dot(m, d) - m;
      const glm::dvec3 lo = glm::transpose(axes_[i]) * p / glm::dvec3(scene_.scale[i]);
      const glm::dvec3 ld = glm::transpose(axes_[i]) * d / glm::dvec3(scene_.scale[i]);
      const double dt = -glm::dot(lo, ld) / glm::dot(ld, ld);
      const glm::dvec3 q = lo + dt * ld;
      const double d2 = glm::dot(q, q);
      const double t = glm::dot(m, d) + dt;
      if (d2 > 9.0 || t <= 0.0) continue;
      ++ellipsoids;
      const double alpha = std::min(0.99, static_cast<double>(scene_.opacity[i]) * std::exp(-0.5 * d2));
      if (alpha >= 1.0 / 255.0) hits.emplace_back(t, alpha);
    }
    if (boxes == 0.0) return;
    std::sort(hits.begin(), hits.end());
    double transmittance = 1.0;
    std::size_t blended = 0;
    while (blended < hits.size() && transmittance >= 0.001) transmittance *= 1.0 - hits[blended++].second;
    result.boxes.push_back(boxes);
    result.ellipsoids.push_back(ellipsoids);
    result.blended.push_back(static_cast<double>(blended));
    result.box_per_ellipsoid.push_back(ellipsoids > 0.0 ? boxes / ellipsoids : 0.0);
    if (transmittance < 0.001) result.share_ended += 1.0;
  }

  const Scene& scene_;
  std::vector<glm::dvec3> half_;  ///< of the 3-sigma boxes
  std::vector<glm::dmat3> axes_;  ///< columns: the local axes in the world
  double diagonal_ = 0.0;
};

}  // namespace grtx::frontend
