// SPDX-License-Identifier: Apache-2.0
// The faces of a proxy in patches of four, as triangle leaves of layout compact hold them. Four connected triangles of
// a convex proxy have six vertices, and a ray enters the proxy through one face only, so a patch has one answer.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "grtx/frontend/gaussian/proxy.h"

namespace grtx::frontend {

struct FacePatch {
  std::array<std::uint16_t, 4> faces{};     ///< face numbers, each next to one before it
  std::array<std::uint16_t, 6> vertices{};  ///< vertex numbers: the first face's, then one per face
  /// Bits 0-2 count of triangles; 3-7 index of the patch; from bit 8 on six bits for each triangle but the first: the
  /// places in `vertices` (three bits each) of the edge that it shares. Triangle i > 0 is that edge, then vertex i + 2.
  std::uint32_t code = 0;
  Box object_box;  ///< contains the face boxes
};

/// The patches of a proxy; for the sphere one patch without faces.
class FacePatches {
 public:
  explicit FacePatches(const Proxy& proxy);

  const std::vector<FacePatch>& patches() const { return patches_; }
  unsigned count() const { return static_cast<unsigned>(patches_.size()); }
  /// By face: the index of its patch.
  const std::array<std::uint8_t, 80>& patch_of() const { return patch_of_; }

 private:
  std::vector<FacePatch> patches_;
  std::array<std::uint8_t, 80> patch_of_{};
};

}  // namespace grtx::frontend
