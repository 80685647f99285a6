// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tiles/tile_structure.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>
#include <limits>

#include "grtx/frontend/accel/embree_builder.h"
#include "grtx/frontend/gaussian/gaussian_math.h"

namespace grtx::frontend {
namespace {

TileGaussian tile_gaussian(const PreparedGaussians& gaussians, std::uint32_t id) {
  const GaussianRecord& record = gaussians.record(id);
  TileGaussian g{};
  g.mean = record.mean;
  double squares = 0.0;
  for (int i = 0; i < 3; ++i) {
    g.to_unit[i] = record.to_unit[i];
    const glm::dvec3 row(record.to_unit[i]);
    squares += (row.x * row.x + row.y * row.y) + row.z * row.z;
  }
  g.norm = static_cast<float>(std::sqrt(squares));
  g.id = id;
  g.kappa2 = record.kappa2;
  g.opacity = record.opacity;
  return g;
}

/// Bounds of one axis of `count` boxes, rounded outwards.
void encode_axis(TileNode& node, int axis, const TreeChild* children, unsigned count) {
  float low = children[0].box.lower[axis], high = children[0].box.upper[axis];
  for (unsigned slot = 1; slot < count; ++slot) {
    low = std::min(low, children[slot].box.lower[axis]);
    high = std::max(high, children[slot].box.upper[axis]);
  }
  float step = (high - low) / 255.0f;
  while (low + 255.0f * step < high) step = std::nextafter(step * 1.0000001f, std::numeric_limits<float>::infinity());
  const auto decoded = [&](int value) { return low + static_cast<float>(value) * step; };
  for (unsigned slot = 0; slot < count; ++slot) {
    const Box& box = children[slot].box;
    const auto place = [&](float at) {
      return step > 0.0f ? std::clamp(static_cast<int>((at - low) / step), 0, 255) : 0;
    };
    int first = place(box.lower[axis]), last = place(box.upper[axis]);
    while (first > 0 && decoded(first) > box.lower[axis]) --first;
    while (last < 255 && decoded(last) < box.upper[axis]) ++last;
    assert(decoded(first) <= box.lower[axis] && decoded(last) >= box.upper[axis]);
    node.lower[axis][slot] = static_cast<std::uint8_t>(first);
    node.upper[axis][slot] = static_cast<std::uint8_t>(last);
  }
  node.origin[axis] = low;
  node.step[axis] = step;
}

}  // namespace

TileStructure::TileStructure(const Scene& scene, const PreparedGaussians& gaussians, ProxyKind proxy)
    : proxy_(proxy), coefficients_(scene.sh_coefficients()) {
  const auto start = std::chrono::steady_clock::now();
  const Tree tree = build_tree(
      gaussians.size(),
      [&](std::size_t g) { return gaussians.instance_box(static_cast<std::uint32_t>(g), proxy_, false); },
      kTileNodeWidth);
  build_seconds_ = tree.build_seconds;
  bounds_ = tree.bounds;
  nodes_.resize(tree.internals);
  gaussians_.reserve(gaussians.size());
  boxes_.reserve(gaussians.size());
  sh_stride_ = (std::size_t{3} * coefficients_ + 3) / 4 * 4;  // degree 3 fills whole cache lines
  sh_.resize(gaussians.size() * sh_stride_);
  std::vector<const TreeNode*> waiting = {tree.root};  // depth first, so that a child's subtree is contiguous
  for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
    const TreeNode& from = *waiting.back();
    waiting.pop_back();
    TileNode& node = nodes_[n];
    const unsigned count = from.child_count;
    node.used = (1u << count) - 1u;
    node.leaves = 0;
    const TreeChild* const children = from.children;
    std::uint32_t next = n + 1;
    for (unsigned slot = count; slot-- > 0;) {
      if (!children[slot].leaf()) waiting.push_back(&children[slot].node());
    }
    for (int axis = 0; axis < 3 && count > 0; ++axis) encode_axis(node, axis, children, count);
    for (unsigned slot = 0; slot < count; ++slot) {
      const TreeChild& child = children[slot];
      if (!child.leaf()) {
        node.child[slot] = next;
        next += child.node().internals;
        continue;
      }
      node.leaves |= 1u << slot;
      node.child[slot] = static_cast<std::uint32_t>(gaussians_.size());
      const float* sh = &scene.sh[std::size_t{3} * coefficients_ * child.primitive()];
      std::copy(sh, sh + std::size_t{3} * coefficients_,
                sh_.begin() + static_cast<std::ptrdiff_t>(sh_stride_ * gaussians_.size()));
      gaussians_.push_back(tile_gaussian(gaussians, child.primitive()));
      boxes_.push_back({child.box});
    }
  }
  total_seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace grtx::frontend
