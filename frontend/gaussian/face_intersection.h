// SPDX-License-Identifier: Apache-2.0
// Intersects a ray with all pairs of parallel faces of a proxy at once: where it enters and leaves the polyhedron, and
// through which faces. Runs on the vector instructions of frontend/gaussian/simd_path.h.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

#include "grtx/frontend/gaussian/simd_path.h"
#include "grtx/frontend/gaussian/slab_intersection.h"

namespace grtx::frontend {

/// Pairs of parallel faces |n.x| <= distance as arrays; padding pairs in the last vector contain every point.
struct FaceSlabs {
  static constexpr unsigned kLanes = 8;
  static constexpr unsigned kMaxPairs = 40;
  alignas(32) std::array<float, kMaxPairs> x{};
  alignas(32) std::array<float, kMaxPairs> y{};
  alignas(32) std::array<float, kMaxPairs> z{};
  alignas(32) std::array<float, kMaxPairs> distance{};
  std::array<std::uint16_t, kMaxPairs> positive{};  ///< face with normal n
  std::array<std::uint16_t, kMaxPairs> negative{};  ///< face with normal -n
  unsigned pairs = 0;
};

/// Entry and exit parameter e of the ray peak + e * direction, and the faces they lie on. Of faces entered at the same
/// e the first counts. Empty when the ray misses.
using FaceTest = Interval (*)(const glm::vec3& peak, const glm::vec3& direction, const FaceSlabs& faces,
                              std::uint32_t& entry_face, std::uint32_t& exit_face);

/// The face test for a path, which must be available.
FaceTest face_test(SimdPath path);

}  // namespace grtx::frontend
