// The faces of a proxy, four to a patch: what a triangle leaf of layout compact holds. Four connected triangles of a
// convex proxy have six vertices, and a ray enters the proxy through one face only, so a patch is one answer.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "grtx/frontend/gaussian/proxy.h"

namespace grtx::frontend {

struct FacePatch {
  std::array<std::uint16_t, 4> faces{};     ///< of the proxy, each next to one before it
  std::array<std::uint16_t, 6> vertices{};  ///< of the proxy: those of the first face, then one each face adds
  /// Bits 0-2 number of triangles; 3-7 number of the patch; from 8 on six bits for each triangle but the first: the
  /// places (three bits each) of the edge that it shares. Triangle i > 0 is that edge, then vertex i + 2.
  std::uint32_t code = 0;
  Box object_box;  ///< holds the face boxes
};

/// The patches of a proxy; of the sphere one without faces.
class FacePatches {
 public:
  explicit FacePatches(const Proxy& proxy);

  const std::vector<FacePatch>& patches() const { return patches_; }
  unsigned count() const { return static_cast<unsigned>(patches_.size()); }
  /// By face: the patch that holds it.
  const std::array<std::uint8_t, 80>& patch_of() const { return patch_of_; }

 private:
  std::vector<FacePatch> patches_;
  std::array<std::uint8_t, 80> patch_of_{};
};

}  // namespace grtx::frontend
