// Packs a built tree into a node image. Every subtree's size is known from the build, so that many are packed at once.
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
  return sizes.header_bytes() + tree.internals * sizes.bytes(NodeKind::internal) + tree.leaves * sizes.bytes(leaf_kind);
}

/// Packs depth first: a node's children lie together, then each child's subtree follows.
/// Leaf: leaf(image, address, primitive) writes one leaf, by any thread. Where there is leaf.prefetch(primitive), it is
/// told some time before which primitive comes.
template <typename Leaf>
class TreePacker {
 public:
  /// consume: the tree's nodes are given back as they are packed, so that image and tree do not take memory at once.
  TreePacker(NodeImage& image, const Tree& tree, NodeKind leaf_kind, Leaf leaf, bool consume = false)
      : image_(image),
        tree_(tree),
        leaf_kind_(leaf_kind),
        internal_bytes_(image.sizes().bytes(NodeKind::internal)),
        leaf_bytes_(image.sizes().bytes(leaf_kind)),
        leaf_(std::move(leaf)),
        consume_(consume) {}

  /// Writes header and nodes to newly allocated bytes; returns the root's address.
  std::uint64_t pack(std::uint64_t bytes) { return pack_at(image_.allocate(bytes)); }
  /// The same over what lies at `header`.
  std::uint64_t pack_at(std::uint64_t header) {
    const std::uint64_t root = header + image_.sizes().header_bytes();
    image_.write_header(header, root, tree_.bounds);
    // What lies above the subtrees is little, and all over the image: it is read first and written last. The subtrees
    // between go from the image's front to its end, so that its pages are first touched as the tree's are given back.
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
    std::uint64_t below;    ///< where all the rest of it goes
  };
  /// What is left of a node of the tree once it is given back.
  struct ReadNode {
    std::uint64_t address, below, below_children;
    unsigned count = 0, inner_count = 0, leaf_count = 0;
    std::array<ChildRecord, traces::kMaxWidth> records;
    std::array<Subtree, traces::kMaxWidth> inner;
    std::array<std::pair<std::uint32_t, std::uint64_t>, traces::kMaxWidth> leaves;  ///< primitive, address
  };
  static constexpr std::uint32_t kSubtreeNodes = 2048;  ///< internal nodes that are packed in one go, at most

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
        if constexpr (requires { leaf_.prefetch(child.primitive()); }) leaf_.prefetch(child.primitive());
        read.leaves[read.leaf_count++] = {child.primitive(), end};
        end += leaf_bytes_;
      } else {
        __builtin_prefetch(&child.node());
        read.inner[read.inner_count++] = {&child.node(), end, 0};
        end += internal_bytes_;
      }
    }
    if (consume_) tree_.memory->release(&node);
    read.below_children = end;
  }

  // Where each child's subtree goes: its nodes have been asked for by read_node().
  void place_inner(ReadNode& read) {
    std::uint64_t end = read.below_children;
    for (unsigned i = 0; i < read.inner_count; ++i) {
      Subtree& inner = read.inner[i];
      inner.below = end;
      end += (inner.root->internals - 1) * internal_bytes_ + inner.root->leaves * leaf_bytes_;
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

  // Subtrees come in the order of their addresses.
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
  Leaf leaf_;
  bool consume_ = false;
};

}  // namespace grtx::frontend
