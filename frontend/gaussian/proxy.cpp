// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/gaussian/proxy.h"

#include <cassert>
#include <glm/geometric.hpp>
#include <map>

namespace grtx::frontend {
namespace {

// Object-space boxes are widened by this much: rays that reach a leaf have coordinates of order 1 there, so their
// arithmetic is good to a few 1e-7.
constexpr float kObjectMargin = 1e-5f;

// The polyhedron must circumscribe the sphere even after its vertices are rounded to fp32 (3DGRT's scale is exact).
constexpr double kRoundingGuard = 1.0 + 4e-7;

}  // namespace

Proxy::Proxy(ProxyKind kind) : kind_(kind) {
  if (kind == ProxyKind::sphere) {
    Box box;
    box.extend(glm::vec3(-1.0f));
    box.extend(glm::vec3(1.0f));
    box.inflate(kObjectMargin);
    face_boxes_.push_back(box);
    circumscribed_radius2_ = 1.0f;
    half_extent_ = 1.0f;
    return;
  }
  make_icosahedron();
  if (kind == ProxyKind::icosphere80) subdivide();
  finish();
}

// Vertices and faces in 3DGRT's order (particlePrimitives.cu); all faces wind counter-clockwise seen from outside.
void Proxy::make_icosahedron() {
  constexpr float p = 1.618033988749895f;
  vertices_ = {{-1, p, 0}, {1, p, 0},  {0, 1, -p},  {-p, 0, -1}, {-p, 0, 1}, {0, 1, p},
               {p, 0, 1},  {0, -1, p}, {-1, -p, 0}, {0, -1, -p}, {p, 0, -1}, {1, -p, 0}};
  triangles_ = {{0, 1, 2},  {0, 2, 3},   {0, 3, 4},  {0, 4, 5},   {0, 5, 1}, {6, 1, 5},  {6, 5, 7},
                {6, 7, 11}, {6, 11, 10}, {6, 10, 1}, {8, 4, 3},   {8, 3, 9}, {8, 9, 11}, {8, 11, 7},
                {8, 7, 4},  {9, 3, 2},   {9, 2, 10}, {9, 10, 11}, {5, 4, 7}, {1, 10, 2}};
}

void Proxy::subdivide() {
  std::vector<glm::dvec3> points;
  for (const glm::vec3& v : vertices_) points.push_back(glm::normalize(glm::dvec3(v)));
  std::map<std::pair<std::uint16_t, std::uint16_t>, std::uint16_t> midpoints;
  const auto midpoint = [&](std::uint16_t a, std::uint16_t b) {
    const auto key = std::minmax(a, b);
    const auto found = midpoints.find(key);
    if (found != midpoints.end()) return found->second;
    points.push_back(glm::normalize(points[a] + points[b]));
    const auto index = static_cast<std::uint16_t>(points.size() - 1);
    midpoints.emplace(key, index);
    return index;
  };
  std::vector<std::array<std::uint16_t, 3>> finer;
  for (const auto& [a, b, c] : triangles_) {
    const std::uint16_t ab = midpoint(a, b), bc = midpoint(b, c), ca = midpoint(c, a);
    finer.push_back({a, ab, ca});
    finer.push_back({b, bc, ab});
    finer.push_back({c, ca, bc});
    finer.push_back({ab, bc, ca});
  }
  triangles_ = std::move(finer);
  vertices_.clear();
  for (const glm::dvec3& q : points) vertices_.push_back(glm::vec3(q));
}

void Proxy::finish() {
  std::vector<glm::dvec3> points;
  for (const glm::vec3& v : vertices_) points.push_back(glm::normalize(glm::dvec3(v)));
  double inscribed = 1.0;
  std::vector<glm::dvec3> normals;
  for (const auto& [a, b, c] : triangles_) {
    const glm::dvec3 n = glm::normalize(glm::cross(points[b] - points[a], points[c] - points[a]));
    normals.push_back(n);
    inscribed = std::min(inscribed, glm::dot(n, points[a]));
  }
  const double scale = kRoundingGuard / inscribed;
  double farthest = 0.0;
  half_extent_ = 0.0f;
  for (std::size_t i = 0; i < points.size(); ++i) {
    vertices_[i] = glm::vec3(points[i] * scale);
    farthest = std::max(farthest, glm::length(points[i] * scale));
    for (int axis = 0; axis < 3; ++axis) half_extent_ = std::max(half_extent_, std::fabs(vertices_[i][axis]));
  }
  circumscribed_radius2_ = static_cast<float>(farthest * farthest * (1.0 + 1e-5));

  std::vector<bool> paired(triangles_.size(), false);
  for (std::size_t f = 0; f < triangles_.size(); ++f) {
    Box box;
    for (const std::uint16_t v : triangles_[f]) box.extend(vertices_[v]);
    box.inflate(kObjectMargin);
    face_boxes_.push_back(box);
    if (paired[f]) continue;
    for (std::size_t g = f + 1; g < triangles_.size(); ++g) {
      if (!paired[g] && glm::dot(normals[f], normals[g]) < -1.0 + 1e-9) {
        paired[f] = paired[g] = true;
        const double distance = glm::dot(normals[f], points[triangles_[f][0]]) * scale;
        face_pairs_.push_back({glm::vec3(normals[f]), static_cast<float>(distance), static_cast<std::uint16_t>(f),
                               static_cast<std::uint16_t>(g)});
        break;
      }
    }
    assert(paired[f]);
  }
  assert(face_pairs_.size() <= FaceSlabs::kMaxPairs);
  face_slabs_.distance.fill(1.0f);  // with normal 0: contains every point
  face_slabs_.pairs = static_cast<unsigned>(face_pairs_.size());
  for (std::size_t i = 0; i < face_pairs_.size(); ++i) {
    const FacePair& pair = face_pairs_[i];
    face_slabs_.x[i] = pair.normal.x;
    face_slabs_.y[i] = pair.normal.y;
    face_slabs_.z[i] = pair.normal.z;
    face_slabs_.distance[i] = pair.distance;
    face_slabs_.positive[i] = pair.positive;
    face_slabs_.negative[i] = pair.negative;
  }
}

}  // namespace grtx::frontend
