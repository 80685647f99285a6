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
    // What lies above the subtrees is packed first, by one thread: it is little.
    std::vector<Subtree> subtrees;
    pack_node({tree_.root, root, root + internal_bytes_}, kSubtreeNodes, &subtrees);
    tbb::parallel_for(std::size_t{0}, subtrees.size(), [&](std::size_t i) { pack_node(subtrees[i], 0, nullptr); });
    return root;
  }

 private:
  struct Subtree {
    const TreeNode* root;
    std::uint64_t address;  ///< of its root
    std::uint64_t below;    ///< where all the rest of it goes
  };
  static constexpr std::uint32_t kSubtreeNodes = 2048;  ///< internal nodes that are packed in one go, at most

  // Children with at most `left_out` nodes are not packed: only their places are noted, in `noted`.
  void pack_node(const Subtree& subtree, std::uint32_t left_out, std::vector<Subtree>* noted) {
    const TreeNode& node = *subtree.root;
    const unsigned count = node.child_count;
    std::array<ChildRecord, traces::kMaxWidth> records;
    std::array<Subtree, traces::kMaxWidth> inner;
    std::array<std::pair<std::uint32_t, std::uint64_t>, traces::kMaxWidth> leaves;  // primitive, address
    unsigned inner_count = 0, leaf_count = 0;
    std::uint64_t end = subtree.below;
    for (unsigned i = 0; i < count; ++i) {
      const TreeChild& child = node.children[i];
      records[i] = {child.box, child.leaf() ? leaf_kind_ : NodeKind::internal};
      if (child.leaf()) {
        if constexpr (requires { leaf_.prefetch(child.primitive()); }) leaf_.prefetch(child.primitive());
        leaves[leaf_count++] = {child.primitive(), end};
        end += leaf_bytes_;
      } else {
        __builtin_prefetch(&child.node());
        inner[inner_count++] = {&child.node(), end, 0};
        end += internal_bytes_;
      }
    }
    const unsigned orientation = node.orientation;
    if (consume_) tree_.memory->release(&node);
    image_.write_internal(subtree.address, subtree.below, records.data(), count, orientation);
    for (unsigned i = 0; i < leaf_count; ++i) leaf_(image_, leaves[i].second, leaves[i].first);
    for (unsigned i = 0; i < inner_count; ++i) {
      inner[i].below = end;
      end += (inner[i].root->internals - 1) * internal_bytes_ + inner[i].root->leaves * leaf_bytes_;
    }
    for (unsigned i = 0; i < inner_count; ++i) {
      if (inner[i].root->internals <= left_out) {
        noted->push_back(inner[i]);
      } else {
        pack_node(inner[i], left_out, noted);
      }
    }
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
