// SPDX-License-Identifier: Apache-2.0
// Packs a built tree into a node image, in parallel: the size of every subtree is known from the build.
#pragma once

#include <tbb/parallel_for.h>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "grtx/frontend/accel/embree_builder.h"
#include "grtx/frontend/accel/node_image.h"

namespace grtx::frontend {

/// Bytes that a packed tree takes, header included.
inline std::uint64_t packed_bytes(const Tree& tree, NodeKind leaf_kind, const traces::NodeSizes& sizes) {
  return sizes.header_bytes() + tree.internals * sizes.bytes(NodeKind::internal) +
         tree.leaves * sizes.bytes(leaf_kind) +
         tree.wide * (sizes.bytes(traces::wide_kind(leaf_kind)) - sizes.bytes(leaf_kind));
}

/// Packs depth first: a node's children lie together, followed by each child's subtree. Leaf: leaf(image, address,
/// primitive) writes one leaf, from any thread. An optional leaf.prefetch(primitive) is called some time before, and an
/// optional leaf.wide(primitive) says whether the leaf is wide, as for the build of the tree.
template <typename Leaf>
class TreePacker {
 public:
  /// consume: releases the tree's nodes as they are packed, so that image and tree do not both take memory.
  TreePacker(NodeImage& image, const Tree& tree, NodeKind leaf_kind, Leaf leaf, bool consume = false)
      : image_(image),
        tree_(tree),
        leaf_kind_(leaf_kind),
        internal_bytes_(image.sizes().bytes(NodeKind::internal)),
        leaf_bytes_(image.sizes().bytes(leaf_kind)),
        wide_bytes_(tree.wide != 0 ? image.sizes().bytes(traces::wide_kind(leaf_kind)) : leaf_bytes_),
        leaf_(std::move(leaf)),
        consume_(consume) {}

  /// Writes header and nodes to newly allocated bytes; returns the root's address.
  std::uint64_t pack(std::uint64_t bytes) { return pack_at(image_.allocate(bytes)); }
  /// The same at `header`, over what is there.
  std::uint64_t pack_at(std::uint64_t header) {
    const std::uint64_t root = header + image_.sizes().header_bytes();
    image_.write_header(header, root, tree_.bounds);
    // The few nodes above the subtrees go to all parts of the image: they are read first and written last. The subtrees
    // go from the image's front to its end, so that its pages are first touched as the tree's pages are released.
    std::vector<Subtree> subtrees;
    std::vector<ReadNode> above;
    divide({tree_.root, root, root + internal_bytes_}, subtrees, above);
    tbb::parallel_for(std::size_t{0}, subtrees.size(), [&](std::size_t i) { pack_subtree(subtrees[i]); });
    for (const ReadNode& node : above) write(node);
    return root;
  }

 private:
  struct Subtree {
    const TreeNode* root;
    std::uint64_t address;  ///< of its root
    std::uint64_t below;    ///< of everything below its root
  };
  /// Contents of a tree node, kept after the node is released.
  struct ReadNode {
    std::uint64_t address, below, below_children;
    unsigned count = 0, inner_count = 0, leaf_count = 0;
    std::array<ChildRecord, traces::kMaxWidth> records;
    std::array<Subtree, traces::kMaxWidth> inner;
    std::array<std::pair<std::uint32_t, std::uint64_t>, traces::kMaxWidth> leaves;  ///< primitive, address
  };
  static constexpr std::uint32_t kSubtreeNodes = 2048;  ///< most internal nodes packed by one task

  void read_node(const Subtree& subtree, ReadNode& read) {
    const TreeNode& node = *subtree.root;
    read.address = subtree.address;
    read.below = subtree.below;
    read.count = node.child_count;
    std::uint64_t end = subtree.below;
    for (unsigned i = 0; i < read.count; ++i) {
      const TreeChild& child = node.children[i];
      read.records[i] = {child.box, child.leaf() ? leaf_kind_ : NodeKind::internal};
      if (child.leaf()) {
        const bool wide = node.wide != 0 && is_wide(child.primitive());
        if (wide) read.records[i].kind = traces::wide_kind(leaf_kind_);
        if constexpr (requires { leaf_.prefetch(child.primitive()); }) leaf_.prefetch(child.primitive());
        read.leaves[read.leaf_count++] = {child.primitive(), end};
        end += wide ? wide_bytes_ : leaf_bytes_;
      } else {
        __builtin_prefetch(&child.node());
        read.inner[read.inner_count++] = {&child.node(), end, 0};
        end += internal_bytes_;
      }
    }
    if (consume_) tree_.memory->release(&node);
    read.below_children = end;
  }

  bool is_wide(std::uint32_t primitive) const {
    if constexpr (requires { leaf_.wide(primitive); }) return leaf_.wide(primitive);
    return false;
  }

  // Sets the addresses of the children's subtrees; read_node() has prefetched their nodes.
  void place_inner(ReadNode& read) {
    std::uint64_t end = read.below_children;
    for (unsigned i = 0; i < read.inner_count; ++i) {
      Subtree& inner = read.inner[i];
      inner.below = end;
      end += (inner.root->internals - 1) * internal_bytes_ + inner.root->leaves * leaf_bytes_ +
             inner.root->wide * (wide_bytes_ - leaf_bytes_);
    }
  }

  void write(const ReadNode& node) {
    image_.write_internal(node.address, node.below, node.records.data(), node.count);
    for (unsigned i = 0; i < node.leaf_count; ++i) leaf_(image_, node.leaves[i].second, node.leaves[i].first);
  }

  void pack_subtree(const Subtree& subtree) {
    ReadNode node;
    read_node(subtree, node);
    write(node);
    place_inner(node);
    for (unsigned i = 0; i < node.inner_count; ++i) pack_subtree(node.inner[i]);
  }

  // Collects the subtrees, in the order of their addresses, and the nodes above them.
  void divide(const Subtree& subtree, std::vector<Subtree>& subtrees, std::vector<ReadNode>& above) {
    ReadNode node;
    read_node(subtree, node);
    place_inner(node);
    for (unsigned i = 0; i < node.inner_count; ++i) {
      if (node.inner[i].root->internals <= kSubtreeNodes) {
        subtrees.push_back(node.inner[i]);
      } else {
        divide(node.inner[i], subtrees, above);
      }
    }
    above.push_back(node);
  }

  NodeImage& image_;
  const Tree& tree_;
  NodeKind leaf_kind_;
  std::uint64_t internal_bytes_;
  std::uint64_t leaf_bytes_;
  std::uint64_t wide_bytes_;
  Leaf leaf_;
  bool consume_ = false;
};

}  // namespace grtx::frontend
