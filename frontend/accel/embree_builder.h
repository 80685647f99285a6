// SPDX-License-Identifier: Apache-2.0
// Wide BVH topology from Embree's rtcBuildBVH: binned SAH, leaf size 1.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "grtx/frontend/accel/tree_memory.h"
#include "grtx/frontend/gaussian/primitive_box.h"
#include "grtx/frontend/gaussian/slab_intersection.h"
#include "grtx/traces/node_layout.h"

namespace grtx::frontend {

struct TreeNode;

/// A child of the built tree: a primitive or a further node.
struct TreeChild {
  Box box;
  std::uintptr_t link = 0;  ///< a leaf: primitive index << 1 | 1; else the node's address

  bool leaf() const { return (link & 1u) != 0; }
  std::uint32_t primitive() const { return static_cast<std::uint32_t>(link >> 1); }
  const TreeNode& node() const { return *reinterpret_cast<const TreeNode*>(link); }
};

struct TreeNode {
  std::uint8_t child_count = 0;
  std::uint8_t levels = 1;                ///< levels of the subtree, this node and its leaves included
  std::uint32_t internals = 1;            ///< nodes of the subtree, this one included
  std::uint32_t leaves = 0;               ///< primitives of the subtree
  std::uint32_t wide = 0;                 ///< of them, those with wide leaves
  TreeChild children[traces::kMaxWidth];  ///< only child_count of them are allocated
};

struct Tree {
  const TreeNode* root = nullptr;  ///< always a node; the last reader may release it (TreeMemory::release)
  std::unique_ptr<TreeMemory> memory;
  Box bounds;
  std::uint32_t internals = 0;
  std::uint32_t leaves = 0;
  std::uint32_t wide = 0;      ///< leaves that are wide
  unsigned height = 0;         ///< levels, root and leaf level included
  double build_seconds = 0.0;  ///< rtcBuildBVH alone
};

/// Writes the boxes of primitives [begin, end) to boxes[0 .. end - begin). Called by several threads at once.
using BoxWriter = std::function<void(std::size_t begin, std::size_t end, PrimitiveBox* boxes)>;

/// Builds a tree of up to `width` children per node over `count` boxes (0: a root without children). write_boxes gets
/// ranges that begin and end at multiples of `group`, which divides count. is_wide: which leaves are wide; null: none.
/// Throws std::runtime_error when Embree fails.
using IsWide = std::function<bool(std::uint32_t primitive)>;
Tree build_tree(std::size_t count, std::size_t group, const BoxWriter& write_boxes, unsigned width,
                const IsWide& is_wide = nullptr);

/// The same over boxes given one by one, by box_of(i).
template <typename BoxOf>
Tree build_tree(std::size_t count, const BoxOf& box_of, unsigned width) {
  return build_tree(
      count, 1,
      [&box_of](std::size_t begin, std::size_t end, PrimitiveBox* boxes) {
        for (std::size_t i = begin; i < end; ++i) boxes[i - begin] = PrimitiveBox(box_of(i));
      },
      width);
}

}  // namespace grtx::frontend
