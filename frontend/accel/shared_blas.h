// SPDX-License-Identifier: Apache-2.0
// The BLAS that all instances of a two-level structure share: the proxy in its unit space.
#pragma once

#include <cstdint>

#include "grtx/frontend/accel/embree_builder.h"
#include "grtx/frontend/accel/node_image.h"
#include "grtx/frontend/gaussian/face_patches.h"
#include "grtx/frontend/gaussian/proxy.h"

namespace grtx::frontend {

class SharedBlas {
 public:
  /// proxy and patches must outlive it.
  SharedBlas(const Proxy& proxy, const FacePatches& patches, traces::NodeLayout layout, unsigned width);

  const Tree& tree() const { return tree_; }
  std::uint64_t bytes() const;
  /// Writes header and nodes to newly allocated bytes of an image of the same layout; returns the root's address.
  std::uint64_t pack(NodeImage& image) const;

 private:
  NodeKind leaf_kind() const { return proxy_.is_sphere() ? NodeKind::procedural : NodeKind::triangle; }

  const Proxy& proxy_;
  const FacePatches& patches_;
  traces::NodeSizes sizes_;
  Tree tree_;
};

}  // namespace grtx::frontend
