// What encoder and decoder of a group know in common while they replay its events: where children lie, and what each
// node did last time. A ray that restarts, or the ray of the next lane, mostly repeats what was seen; the columns then
// hold zeros, which compress to nothing.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "traces/event.h"
#include "traces/header.h"
#include "traces/node_shape.h"

namespace grtx::traces {

/// A node (or a pseudo parent, see GroupModel) with what the coder remembers of it.
struct NodeModel {
  std::uint32_t child_base = 0;         ///< / kNodeUnit
  std::uint32_t offsets = 0;            ///< as in NodeShape
  std::uint32_t priority = 0x76543210;  ///< four bits a place: slots, in the order in which they were last popped
  std::array<std::uint8_t, kMaxWidth> last_op{};  ///< symbol of the child's last pop
  std::uint8_t child_count = 0;
  std::uint8_t internal_mask = 0;  ///< as in NodeShape
  std::uint8_t instance_mask = 0;  ///< as in NodeShape
  std::uint8_t wide_mask = 0;      ///< as in NodeShape
  std::uint8_t last_hits = 0;      ///< children hit at the last visit

  std::uint32_t child_address(unsigned slot) const { return child_base + ((offsets >> (4 * slot)) & 0xF); }
  bool is_internal(unsigned slot) const { return (internal_mask >> slot & 1) != 0; }
  bool is_instance(unsigned slot) const { return (instance_mask >> slot & 1) != 0; }
  /// Slot of the child at `address`; kMaxWidth when no child of `remaining` begins there.
  unsigned slot_of(std::uint32_t remaining, std::uint32_t address) const {
    const std::uint32_t offset = address - child_base;
    if (offset > 15) return kMaxWidth;
    const unsigned slot = kSlotAtOffset[wide_mask][offset];
    return (remaining >> slot & 1) != 0 ? slot : kMaxWidth;
  }

  /// How many slots of `remaining` come before `slot` in the priority order; then moves `slot` before them.
  unsigned rank_of(unsigned remaining, unsigned slot) {
    if ((priority & 7) == slot) return 0;
    return rank_behind_first(remaining, slot);
  }
  /// The slot of `remaining` with `rank` before it; then moves it before them. rank < popcount(remaining).
  unsigned slot_at(unsigned remaining, unsigned rank) {
    const unsigned first = priority & 7;
    if (rank == 0 && (remaining >> first & 1) != 0) return first;
    return slot_behind_first(remaining, rank);
  }

 private:
  unsigned rank_behind_first(unsigned remaining, unsigned slot);
  unsigned slot_behind_first(unsigned remaining, unsigned rank);
  void move_up(unsigned from, unsigned to);
};

/// An entry of a checkpoint buffer or of the stack: one child of one node, reached through one instance.
struct NodeReference {
  std::uint32_t parent = 0;  ///< index into the model
  std::uint32_t slot = 0;
  std::uint32_t context = 0;  ///< address of the instance leaf / kNodeUnit; 0 outside the BLAS
};

/// Children of one parent that are on the stack and not popped yet.
struct StackFrame {
  std::uint32_t parent = 0;
  std::uint32_t context = 0;
  std::uint32_t remaining = 0;  ///< mask of slots, not empty
};

/// All nodes of a group's dictionary, then two pseudo parents: one whose only child is the root, one whose only child
/// is the BLAS root.
class GroupModel {
 public:
  static constexpr std::uint32_t kUnknownLink = 0xFFFFFFFF;

  /// Throws std::invalid_argument when the dictionary breaks a rule (order, child kinds, node image).
  void build(const Header& header, const std::vector<NodeDefinition>& nodes, NodeKind root_kind);
  /// Makes link() possible.
  void prepare_links() { links_.assign(kMaxWidth * nodes_.size(), kUnknownLink); }

  NodeModel& operator[](std::uint32_t index) { return nodes_[index]; }
  const NodeModel& operator[](std::uint32_t index) const { return nodes_[index]; }
  /// Of a dictionary node.
  std::uint32_t address(std::uint32_t index) const { return addresses_[index]; }
  std::uint32_t root_parent() const { return static_cast<std::uint32_t>(nodes_.size() - 2); }
  std::uint32_t blas_root_parent() const { return static_cast<std::uint32_t>(nodes_.size() - 1); }
  bool is_blas(std::uint32_t address) const { return address >= blas_begin_; }

  /// Index of the internal node at a child slot; kUnknownLink when the dictionary lacks it.
  std::uint32_t link(std::uint32_t parent, unsigned slot) {
    std::uint32_t& known = links_[kMaxWidth * parent + slot];
    if (known == kUnknownLink) known = find(nodes_[parent].child_address(slot));
    return known;
  }
  /// Index of the dictionary node at `address`; kUnknownLink when absent.
  std::uint32_t find(std::uint32_t address) const;

  /// Shape of any node of the trace last built for.
  const NodeShape& shape(const Header& header, const NodeDefinition& node) {
    shapes_.set_width(header.bvh_width);
    return shapes_.of(node);
  }

 private:
  std::vector<NodeModel> nodes_;
  std::vector<std::uint32_t> addresses_;   ///< of the dictionary's nodes, close together for the search
  std::vector<std::uint32_t> links_;       ///< eight a node
  std::uint32_t blas_begin_ = 0xFFFFFFFF;  ///< first address inside the BLAS / kNodeUnit
  ShapeTable shapes_;
};

}  // namespace grtx::traces
