// Wide BVH topology from Embree's rtcBuildBVH: binned SAH, leaf size 1.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "frontend/slab_test.h"

namespace grtx::frontend {

/// A node of the built tree: an index into Tree::internals, or a primitive.
struct TreeChild {
  Box box;
  std::uint32_t index = 0;
  bool leaf = false;
};

struct TreeNode {
  std::uint32_t first_child = 0;  ///< into Tree::children
  std::uint32_t child_count = 0;
};

struct Tree {
  std::vector<TreeNode> internals;  ///< internals[0] is the root
  std::vector<TreeChild> children;  ///< of one node together; nodes depth first, each child's subtree in turn
  Box bounds;
  unsigned height = 0;         ///< levels, root and leaf level included
  double build_seconds = 0.0;  ///< rtcBuildBVH alone
};

/// Builds a tree of `width` children over `count` boxes given by box_of(i). count may be 0 (a root without children).
/// Throws std::runtime_error when Embree fails.
Tree build_tree(std::size_t count, const std::function<Box(std::size_t)>& box_of, unsigned width);

}  // namespace grtx::frontend
