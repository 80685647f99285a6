// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/reference/reference_solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

namespace grtx::frontend {
namespace {

using Triangle = std::array<glm::dvec3, 3>;

/// The faces of the icosahedron with vertices (0, +-1, +-phi) and cyclic: all triples of vertices at distance 2.
std::vector<Triangle> icosahedron() {
  const double phi = 0.5 * (1.0 + std::sqrt(5.0));
  std::vector<glm::dvec3> vertices;
  for (const double one : {-1.0, 1.0}) {
    for (const double p : {-phi, phi}) {
      vertices.emplace_back(0.0, one, p);
      vertices.emplace_back(one, p, 0.0);
      vertices.emplace_back(p, 0.0, one);
    }
  }
  const auto edge = [&](std::size_t a, std::size_t b) {
    return std::abs(glm::distance(vertices[a], vertices[b]) - 2.0) < 1e-9;
  };
  std::vector<Triangle> faces;
  for (std::size_t a = 0; a < vertices.size(); ++a) {
    for (std::size_t b = a + 1; b < vertices.size(); ++b) {
      for (std::size_t c = b + 1; c < vertices.size(); ++c) {
        if (edge(a, b) && edge(b, c) && edge(c, a)) faces.push_back({vertices[a], vertices[b], vertices[c]});
      }
    }
  }
  return faces;
}

/// Every face split at its edge midpoints; all vertices on the unit sphere.
std::vector<Triangle> icosphere() {
  std::vector<Triangle> faces;
  for (const auto& [p, q, r] : icosahedron()) {
    const glm::dvec3 a = glm::normalize(p);
    const glm::dvec3 b = glm::normalize(q);
    const glm::dvec3 c = glm::normalize(r);
    const glm::dvec3 ab = glm::normalize(a + b);
    const glm::dvec3 bc = glm::normalize(b + c);
    const glm::dvec3 ca = glm::normalize(c + a);
    faces.insert(faces.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  return faces;
}

std::vector<Triangle> faces_of(ReferenceProxy proxy) {
  switch (proxy) {
    case ReferenceProxy::icosahedron20:
      return icosahedron();
    case ReferenceProxy::icosphere80:
      return icosphere();
    case ReferenceProxy::sphere:
      break;
  }
  return {};
}

/// Outward unit normal and distance of the face's plane from the centre.
ReferenceSlab plane_of(const Triangle& face) {
  glm::dvec3 normal = glm::normalize(glm::cross(face[1] - face[0], face[2] - face[0]));
  double distance = glm::dot(normal, face[0]);
  if (distance < 0.0) {
    normal = -normal;
    distance = -distance;
  }
  return {normal, distance};
}

double inscribed_radius(const std::vector<Triangle>& faces) {
  double radius = plane_of(faces.front()).distance;
  for (const Triangle& face : faces) radius = std::min(radius, plane_of(face).distance);
  return radius;
}

}  // namespace

std::vector<ReferenceSlab> reference_slabs(ReferenceProxy proxy) {
  const std::vector<Triangle> faces = faces_of(proxy);
  std::vector<ReferenceSlab> slabs;
  if (faces.empty()) return slabs;
  const double inscribed = inscribed_radius(faces);
  for (const Triangle& face : faces) {
    ReferenceSlab slab = plane_of(face);
    const bool opposite_is_there = std::any_of(slabs.begin(), slabs.end(), [&](const ReferenceSlab& other) {
      return glm::dot(other.normal, slab.normal) < -1.0 + 1e-9;
    });
    slab.distance /= inscribed;
    if (!opposite_is_there) slabs.push_back(slab);
  }
  return slabs;
}

double reference_circumradius(ReferenceProxy proxy) {
  const std::vector<Triangle> faces = faces_of(proxy);
  if (faces.empty()) return 1.0;
  double farthest = 0.0;
  for (const Triangle& face : faces) {
    for (const glm::dvec3& vertex : face) farthest = std::max(farthest, glm::length(vertex));
  }
  return farthest / inscribed_radius(faces);
}

}  // namespace grtx::frontend
