#include "frontend/tile_structure.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "frontend/embree_builder.h"
#include "frontend/gaussian_math.h"

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

}  // namespace

TileStructure::TileStructure(const Scene& scene, const PreparedGaussians& gaussians, ProxyKind proxy)
    : proxy_(proxy), coefficients_(std::min(kShFunctions, scene.sh_coefficients())) {
  const auto start = std::chrono::steady_clock::now();
  const Tree tree = build_tree(
      gaussians.size(),
      [&](std::size_t g) { return gaussians.instance_box(static_cast<std::uint32_t>(g), proxy_, false); },
      kTileNodeWidth);
  build_seconds_ = tree.build_seconds;
  bounds_ = tree.bounds;
  nodes_.resize(tree.internals.size());
  gaussians_.reserve(gaussians.size());
  boxes_.reserve(gaussians.size());
  sh_stride_ = (std::size_t{3} * coefficients_ + 3) / 4 * 4;  // degree 3 fills whole cache lines
  sh_.resize(gaussians.size() * sh_stride_);
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    TileNode& node = nodes_[n];
    const unsigned count = tree.internals[n].child_count;
    node.used = (1u << count) - 1u;
    node.leaves = 0;
    for (unsigned slot = 0; slot < kTileNodeWidth; ++slot) {
      const bool used = slot < count;
      const TreeChild child = used ? tree.children[tree.internals[n].first_child + slot] : TreeChild{};
      for (int axis = 0; axis < 3; ++axis) {
        node.bounds[2 * axis][slot] = used ? child.box.lower[axis] : 0.0f;
        node.bounds[2 * axis + 1][slot] = used ? child.box.upper[axis] : 0.0f;
      }
      if (used && child.leaf) {
        node.leaves |= 1u << slot;
        node.child[slot] = static_cast<std::uint32_t>(gaussians_.size());
        const float* from = &scene.sh[std::size_t{3} * scene.sh_coefficients() * child.index];
        std::copy(from, from + std::size_t{3} * coefficients_,
                  sh_.begin() + static_cast<std::ptrdiff_t>(sh_stride_ * gaussians_.size()));
        gaussians_.push_back(tile_gaussian(gaussians, child.index));
        boxes_.push_back({child.box});
      } else {
        node.child[slot] = child.index;
      }
    }
  }
  total_seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace grtx::frontend
