// SPDX-License-Identifier: Apache-2.0
// The structure that tile tracing (frontend/tiles/tile_tracer.h) walks: its own BVH over the boxes of whole proxies,
// eight children per node, and the Gaussians in the order of its leaves. Not part of traces; it only must lead to every
// hit.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "grtx/base/huge_pages.h"
#include "grtx/frontend/gaussian/prepared_gaussians.h"
#include "grtx/frontend/gaussian/proxy.h"
#include "grtx/frontend/gaussian/slab_intersection.h"
#include "grtx/frontend/scene/scene.h"

namespace grtx::frontend {

inline constexpr unsigned kTileNodeWidth = 8;

/// Two cache lines, because a walk is bound by memory more than by arithmetic.
struct alignas(64) TileNode {
  float origin[3];  ///< of the children's bounds
  float step[3];
  /// By axis: lower and upper bounds of the children are origin + step * value, in this order of fp32 operations.
  std::uint8_t lower[3][kTileNodeWidth];
  std::uint8_t upper[3][kTileNodeWidth];
  std::uint32_t child[kTileNodeWidth];  ///< index of a node or of a Gaussian
  std::uint32_t used;                   ///< mask of slots in use
  std::uint32_t leaves;                 ///< mask of children that are Gaussians

  Box box(unsigned slot) const {
    Box result;
    for (int axis = 0; axis < 3; ++axis) {
      result.lower[axis] = origin[axis] + static_cast<float>(lower[axis][slot]) * step[axis];
      result.upper[axis] = origin[axis] + static_cast<float>(upper[axis][slot]) * step[axis];
    }
    return result;
  }
};
static_assert(sizeof(TileNode) == 128);

/// All that decides which rays come close to a Gaussian and, except for the box, where they hit it.
struct alignas(64) TileGaussian {
  glm::vec3 mean;
  float norm;            ///< Frobenius norm of to_unit
  glm::vec3 to_unit[3];  ///< as in GaussianRecord
  float kappa2;
  float opacity;
  std::uint32_t id;  ///< in the scene
};
static_assert(sizeof(TileGaussian) == 64);

/// Box of the whole proxy; for a sphere the box that contains its hits.
struct alignas(32) TileBox {
  Box box;
};

class TileStructure {
 public:
  TileStructure(const Scene& scene, const PreparedGaussians& gaussians, ProxyKind proxy);

  const Proxy& proxy() const { return proxy_; }
  /// Node 0 is the root.
  const TileNode& node(std::uint32_t index) const { return nodes_[index]; }
  const TileGaussian& gaussian(std::uint32_t index) const { return gaussians_[index]; }
  const TileBox& box(std::uint32_t index) const { return boxes_[index]; }
  /// Spherical harmonics of a Gaussian: coefficient-major, r g b inner.
  const float* sh(std::uint32_t index) const { return sh_.data() + index * sh_stride_; }
  unsigned coefficients() const { return coefficients_; }
  std::size_t nodes() const { return nodes_.size(); }
  const Box& bounds() const { return bounds_; }
  double build_seconds() const { return build_seconds_; }  ///< rtcBuildBVH alone
  double total_seconds() const { return total_seconds_; }  ///< the whole constructor

 private:
  Proxy proxy_;
  HugePageVector<TileNode> nodes_;
  HugePageVector<TileGaussian> gaussians_;
  HugePageVector<TileBox> boxes_;
  HugePageVector<float> sh_;
  std::size_t sh_stride_;
  unsigned coefficients_;
  Box bounds_;
  double build_seconds_ = 0.0;
  double total_seconds_ = 0.0;
};

}  // namespace grtx::frontend
