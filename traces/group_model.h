// What encoder and decoder of a group know in common while they replay its events: where children lie, and what each
// node did last time. A ray that restarts, or the ray of the next lane, mostly repeats what was seen, and what repeats
// takes no bytes.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "traces/event.h"
#include "traces/header.h"
#include "traces/node_shape.h"

namespace grtx::traces {

/// A node (or a pseudo parent, see GroupModel) with what the coder remembers of it: one cache line.
struct alignas(64) NodeModel {
  static constexpr std::uint32_t kUnknownLink = 0;  ///< the root's pseudo parent, which is nobody's child
  /// Slots that come before a slot in the order in which they are expected to be popped, a byte a slot; at first that
  /// is the order of slots.
  std::uint64_t before = 0x7F3F1F0F07030100;
  std::array<std::uint8_t, kMaxWidth> last_op{};  ///< symbol of the child's last pop
  std::uint32_t child_base = 0;                   ///< / kNodeUnit
  std::uint32_t offsets = 0;                      ///< as in NodeShape
  std::array<std::uint32_t, kMaxWidth> links{};   ///< index of the internal node in each slot, if known
  std::uint8_t child_count = 0;
  std::uint8_t internal_mask = 0;  ///< as in NodeShape
  std::uint8_t instance_mask = 0;  ///< as in NodeShape
  std::uint8_t wide_mask = 0;      ///< as in NodeShape
  std::uint8_t last_hits = 0;      ///< children hit at the last visit

  std::uint32_t child_address(unsigned slot) const { return child_base + ((offsets >> (4 * slot)) & 0xF); }
  bool is_internal(unsigned slot) const { return (internal_mask >> slot & 1) != 0; }
  bool is_instance(unsigned slot) const { return (instance_mask >> slot & 1) != 0; }
  /// Slot of the child of `remaining` at `address`; kMaxWidth when there is none.
  unsigned slot_of(std::uint32_t remaining, std::uint32_t address) const {
    const std::uint32_t offset = address - child_base;
    if (offset > 15) return kMaxWidth;
    const unsigned slot = kSlotAtOffset[wide_mask][offset];
    return (remaining >> slot & 1) != 0 ? slot : kMaxWidth;
  }

  /// How many slots of `remaining` are expected before `slot`.
  unsigned rank_of(unsigned remaining, unsigned slot) const {
    return bits_of_byte(static_cast<unsigned>(before >> (8 * slot)) & remaining);
  }
  /// The slot of `remaining` (not empty) that is expected first: the one that has none of them before it.
  unsigned first_of(unsigned remaining) const {
    const std::uint64_t others = (kOnes * (~remaining & 0xFF)) & kDiagonal;
    const std::uint64_t bytes = (before & kOnes * remaining) | others;
    const std::uint64_t zeros = (bytes - kOnes) & ~bytes & 0x80 * kOnes;  // exact up to the first zero byte
    return static_cast<unsigned>(std::countr_zero(zeros)) / 8;
  }
  /// The slot of `remaining` with `rank` (below the number of slots in it) of them before it.
  unsigned slot_at(unsigned remaining, unsigned rank) const {
    for (unsigned left = remaining;; left &= left - 1) {
      const auto slot = static_cast<unsigned>(std::countr_zero(left));
      if (rank_of(remaining, slot) == rank) return slot;
    }
  }
  /// `slot`, which was popped although others of `remaining` were expected first, moves before the first of them.
  void move_up(unsigned remaining, unsigned slot) {
    const std::uint64_t of_first = before >> (8 * first_of(remaining)) & 0xFF;
    const std::uint64_t passed = before >> (8 * slot) & 0xFF & ~of_first;
    before = (before & ~(std::uint64_t{0xFF} << (8 * slot))) | of_first << (8 * slot);
    const std::uint64_t spread = (kOnes * passed) & kDiagonal;  // byte i is not zero if bit i is set
    before |= ((spread + 0x7F * kOnes) >> 7 & kOnes) << slot;
  }

 private:
  static constexpr std::uint64_t kOnes = 0x0101010101010101;
  static constexpr std::uint64_t kDiagonal = 0x8040201008040201;
};
static_assert(sizeof(NodeModel) == 64);

/// An entry of a checkpoint buffer: one child of one node, reached through one instance.
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

/// Two pseudo parents, one whose only child is the root, one whose only child is the BLAS root; then the nodes of a
/// group.
class GroupModel {
 public:
  static constexpr std::uint32_t kRootParent = 0;
  static constexpr std::uint32_t kBlasRootParent = 1;
  static constexpr std::uint32_t kFirstNode = 2;

  /// Forgets all nodes.
  void begin(const Header& header, NodeKind root_kind);
  /// Throws std::invalid_argument when the node breaks a rule (child kinds, node image). References to nodes become
  /// invalid.
  std::uint32_t add(const NodeDefinition& node, const NodeShape& shape);
  /// Shape of any node of the trace.
  const NodeShape& shape(const NodeDefinition& node) { return shapes_.of(node); }

  std::size_t size() const { return nodes_.size(); }
  NodeModel* nodes() { return nodes_.data(); }
  NodeModel& operator[](std::uint32_t index) { return nodes_[index]; }
  const NodeModel& operator[](std::uint32_t index) const { return nodes_[index]; }
  bool is_blas(std::uint32_t address) const { return address >= blas_begin_; }

 private:
  std::vector<NodeModel> nodes_;
  std::uint32_t blas_begin_ = 0xFFFFFFFF;  ///< first address inside the BLAS / kNodeUnit
  std::uint64_t image_units_ = 0;
  std::uint64_t internal_units_ = 0;
  ShapeTable shapes_;
};

}  // namespace grtx::traces
