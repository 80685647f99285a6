// Turns a tree's boxes into oriented ones (layout obb): every node gets the rotation in which its children's boxes are
// smallest. Bottom-up, as DOBB-BVH does (arXiv 2506.22849): a node's extents along the axes of all rotations are those
// of its children.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "grtx/frontend/accel/embree_builder.h"
#include "grtx/frontend/accel/orientations.h"
#include "grtx/frontend/gaussian/prepared_gaussians.h"
#include "grtx/frontend/gaussian/proxy.h"

namespace grtx::frontend {

/// What something reaches along the axes of every rotation: axis a of rotation r at a * kOrientations + r.
struct FrameExtents {
  static constexpr unsigned kDirections = 3 * kOrientations;
  static_assert(kOrientations % 4 == 0);  // vectors of four
  alignas(16) std::array<float, kDirections> lower;
  alignas(16) std::array<float, kDirections> upper;

  Box box(unsigned orientation) const;
  void extend(const FrameExtents& other);
};

/// Extents of a primitive. Called by several threads at once.
using ExtentsOf = std::function<void(std::uint32_t primitive, FrameExtents& extents)>;

/// Chooses an orientation for every node but the root, and puts the children's boxes into its frame. Returns how many
/// nodes have another one than the identity. tree: as built, read by nobody else meanwhile.
std::uint64_t orient_tree(const Tree& tree, const ExtentsOf& extents_of);

/// Extents of what rays can hit of a Gaussian, widened by the bound that docs/model/node-image.md derives.
class ProxyExtents {
 public:
  /// Both must outlive it.
  ProxyExtents(const PreparedGaussians& gaussians, const Proxy& proxy) : gaussians_(gaussians), proxy_(proxy) {}

  /// Extents of face `face` alone; of a sphere: of the whole ellipsoid.
  void of_face(std::uint32_t g, unsigned face, FrameExtents& extents) const;
  /// Extents of the whole proxy.
  void of_proxy(std::uint32_t g, FrameExtents& extents) const;

 private:
  const PreparedGaussians& gaussians_;
  const Proxy& proxy_;
};

/// orient_tree() of a TLAS, one instance a Gaussian.
std::uint64_t orient_instances(const Tree& tlas, const PreparedGaussians& gaussians, const Proxy& proxy);

}  // namespace grtx::frontend
