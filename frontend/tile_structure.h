// What tile tracing (frontend/tile_tracer.h) walks: a BVH of its own over the boxes of whole proxies, eight children a
// node, and the Gaussians in the order of its leaves. No trace shows it; it only has to lead to every hit.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "base/huge_pages.h"
#include "frontend/prepared_gaussians.h"
#include "frontend/proxy.h"
#include "frontend/slab_test.h"

namespace grtx::frontend {

inline constexpr unsigned kTileNodeWidth = 8;
inline constexpr std::uint32_t kTileLeaf = 0x80000000u;  ///< marks a child that is a Gaussian

struct alignas(64) TileNode {
  /// Lower x of the children, upper x, lower y, upper y, lower z, upper z; world space.
  float bounds[6][kTileNodeWidth];
  /// Index of a node; or of a Gaussian, with kTileLeaf.
  std::uint32_t child[kTileNodeWidth];
  std::uint32_t count;
};
static_assert(sizeof(TileNode) == 256);

/// The first cache line decides which rays come close, the second what they hit.
struct alignas(64) TileGaussian {
  glm::vec3 mean;
  float norm;             ///< Frobenius norm of to_unit
  glm::vec3 to_unit[3];   ///< as in GaussianRecord
  std::uint32_t id;       ///< in the scene
  std::uint32_t unused[2];
  Box box;                ///< of the whole proxy; of a sphere, the box that its hit must lie in
  float kappa2;
  float opacity;
  float unused2[8];
};
static_assert(sizeof(TileGaussian) == 128);

class TileStructure {
 public:
  TileStructure(const PreparedGaussians& gaussians, ProxyKind proxy);

  const Proxy& proxy() const { return proxy_; }
  /// Node 0 is the root.
  const TileNode& node(std::uint32_t index) const { return nodes_[index]; }
  const TileGaussian& gaussian(std::uint32_t index) const { return gaussians_[index]; }
  std::size_t nodes() const { return nodes_.size(); }
  const Box& bounds() const { return bounds_; }
  double build_seconds() const { return build_seconds_; }  ///< rtcBuildBVH alone
  double total_seconds() const { return total_seconds_; }  ///< the whole constructor

 private:
  Proxy proxy_;
  HugePageVector<TileNode> nodes_;
  HugePageVector<TileGaussian> gaussians_;
  Box bounds_;
  double build_seconds_ = 0.0;
  double total_seconds_ = 0.0;
};

}  // namespace grtx::frontend
