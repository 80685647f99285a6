// SPDX-License-Identifier: Apache-2.0
// Bounding proxies of the unit sphere: icosahedron, icosphere and the sphere itself, with inscribed radius 1.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "grtx/frontend/gaussian/face_intersection.h"
#include "grtx/frontend/gaussian/slab_intersection.h"

namespace grtx::frontend {

enum class ProxyKind : std::uint8_t { icosahedron20, icosphere80, sphere };

/// A pair of parallel faces |n.x| <= distance; positive and negative are the face numbers with normals n and -n.
struct FacePair {
  glm::vec3 normal{0.0f};  ///< unit
  float distance = 1.0f;   ///< >= 1
  std::uint16_t positive = 0;
  std::uint16_t negative = 0;
};

/// A convex, centrally symmetric polyhedron around the unit sphere; no faces for the sphere itself.
class Proxy {
 public:
  explicit Proxy(ProxyKind kind);

  ProxyKind kind() const { return kind_; }
  bool is_sphere() const { return kind_ == ProxyKind::sphere; }
  unsigned faces() const { return static_cast<unsigned>(triangles_.size()); }
  const std::vector<glm::vec3>& vertices() const { return vertices_; }
  const std::vector<std::array<std::uint16_t, 3>>& triangles() const { return triangles_; }
  const std::vector<FacePair>& face_pairs() const { return face_pairs_; }
  /// The same pairs in the format of the face test.
  const FaceSlabs& face_slabs() const { return face_slabs_; }
  /// Object-space box of a face (of the sphere: face 0), widened so that rounding never loses a hit.
  const Box& face_box(unsigned face) const { return face_boxes_[face]; }
  /// Squared distance from the centre beyond which no ray hits the proxy.
  float circumscribed_radius2() const { return circumscribed_radius2_; }
  /// Half extent of the axis-aligned box of the proxy.
  float half_extent() const { return half_extent_; }

 private:
  void make_icosahedron();
  void subdivide();
  void finish();

  ProxyKind kind_;
  std::vector<glm::vec3> vertices_;
  std::vector<std::array<std::uint16_t, 3>> triangles_;
  std::vector<FacePair> face_pairs_;
  FaceSlabs face_slabs_;
  std::vector<Box> face_boxes_;
  float circumscribed_radius2_ = 1.0f;
  float half_extent_ = 1.0f;
};

}  // namespace grtx::frontend
