// Packs a built tree into a node image.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <utility>

#include "base/huge_pages.h"
#include "frontend/embree_builder.h"
#include "frontend/node_image.h"

namespace grtx::frontend {

/// Writes one leaf at `address` for tree leaf `index`.
using LeafWriter = std::function<void(NodeImage&, std::uint64_t address, std::uint32_t index)>;

/// Packs depth first: a node's children lie together, then each child's subtree follows.
class TreePacker {
 public:
  /// consume: the tree's children are lost as they are packed, so that image and tree do not take memory at once.
  TreePacker(NodeImage& image, const Tree& tree, NodeKind leaf_kind, LeafWriter write_leaf, bool consume = false)
      : image_(image), tree_(tree), leaf_kind_(leaf_kind), write_leaf_(std::move(write_leaf)), consume_(consume) {}

  /// Writes header and nodes to newly allocated bytes; returns the root's address.
  std::uint64_t pack(std::uint64_t bytes) { return pack_at(image_.allocate(bytes)); }
  /// The same over what lies at `header`.
  std::uint64_t pack_at(std::uint64_t header) {
    next_ = header;
    take(traces::kHeaderBytes);
    const std::uint64_t root = take(traces::internal_bytes(image_.width()));
    image_.write_header(header, root, tree_.bounds);
    pack_node(0, root);
    return root;
  }

 private:
  std::uint64_t take(std::uint64_t bytes) { return std::exchange(next_, next_ + bytes); }

  void pack_node(std::uint32_t index, std::uint64_t address) {
    const TreeNode& node = tree_.internals[index];
    std::array<TreeChild, traces::kMaxWidth> children;
    std::copy_n(tree_.children.begin() + node.first_child, node.child_count, children.begin());
    if (consume_) release_up_to(node.first_child);
    std::array<ChildRecord, traces::kMaxWidth> records;
    std::array<std::uint64_t, traces::kMaxWidth> addresses{};
    std::uint64_t bytes = 0;
    for (unsigned i = 0; i < node.child_count; ++i) {
      const TreeChild& child = children[i];
      records[i] = {child.box, child.leaf ? leaf_kind_ : NodeKind::internal};
      addresses[i] = bytes;
      bytes += traces::node_bytes(records[i].kind, image_.width());
    }
    const std::uint64_t base = take(bytes);
    image_.write_internal(address, base, records.data(), node.child_count);
    for (unsigned i = 0; i < node.child_count; ++i) {
      const TreeChild& child = children[i];
      if (child.leaf) {
        write_leaf_(image_, base + addresses[i], child.index);
      } else {
        pack_node(child.index, base + addresses[i]);
      }
    }
  }

  // Children lie in the order in which they are packed (build_tree): nobody reads those before `child` again.
  void release_up_to(std::uint32_t child) {
    if (child < released_ + kReleasedAtOnce) return;
    release_pages(&tree_.children[released_], &tree_.children[child]);
    released_ = child;
  }

  static constexpr std::uint32_t kReleasedAtOnce = 1u << 18;  ///< 8 MiB
  NodeImage& image_;
  const Tree& tree_;
  NodeKind leaf_kind_;
  LeafWriter write_leaf_;
  bool consume_ = false;
  std::uint32_t released_ = 0;
  std::uint64_t next_ = 0;
};

/// Bytes that a packed tree takes, header included.
inline std::uint64_t packed_bytes(const Tree& tree, NodeKind leaf_kind, unsigned width) {
  const auto leaves = static_cast<std::uint64_t>(
      std::count_if(tree.children.begin(), tree.children.end(), [](const TreeChild& c) { return c.leaf; }));
  return traces::kHeaderBytes + tree.internals.size() * traces::internal_bytes(width) +
         leaves * traces::node_bytes(leaf_kind, width);
}

}  // namespace grtx::frontend
