// SPDX-License-Identifier: Apache-2.0
// The prediction model that encoder and decoder of a group share while they replay its events: where children lie, and
// the outcome of each node's last visit. A ray that restarts, or the ray of the next lane, mostly repeats earlier
// visits, and correct predictions take no bytes.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "grtx/traces/codec/node_shape.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"
#include "grtx/traces/instance_levels.h"

namespace grtx::traces {

/// A node (or a pseudo parent, see GroupModel) and its predictions, in one cache line.
struct alignas(64) NodeModel {
  static constexpr std::uint32_t kUnknownLink = 0;  ///< index of the root's pseudo parent, which is never a child
  /// Expected pop order of the slots: one byte per place, the first in the lowest byte, with the slot's bit set.
  std::uint64_t order = kDiagonal;
  std::array<std::uint8_t, kMaxWidth> last_op{};  ///< symbol of the child's last pop
  std::uint32_t child_base = 0;                   ///< in units
  std::uint32_t offsets = 0;                      ///< as in NodeShape
  std::array<std::uint32_t, kMaxWidth> links{};   ///< [slot] index of the child, or kUnknownLink
  std::uint8_t child_count = 0;
  std::uint8_t internal_mask = 0;  ///< as in NodeShape
  std::uint8_t instance_mask = 0;  ///< as in NodeShape
  std::uint8_t wide_mask = 0;      ///< as in NodeShape
  std::uint8_t last_hits = 0;      ///< children hit at the last visit

  std::uint32_t child_address(unsigned slot) const { return child_base + ((offsets >> (4 * slot)) & 0xF); }
  bool is_internal(unsigned slot) const { return (internal_mask >> slot & 1) != 0; }
  bool is_instance(unsigned slot) const { return (instance_mask >> slot & 1) != 0; }
  /// Slot in mask `remaining` of the child at `address`; kMaxWidth if there is none.
  unsigned slot_of(std::uint32_t remaining, std::uint32_t address) const {
    const std::uint32_t offset = address - child_base;
    if (offset > 15) return kMaxWidth;
    const unsigned slot = kSlotAtOffset[wide_mask][offset];
    return (remaining >> slot & 1) != 0 ? slot : kMaxWidth;
  }

  /// Initial `order` for a child order (traces/orders/child_order.h): as if all slots were hit, in slot order of t.
  template <typename Policy>
  static constexpr std::uint64_t order_of(Policy) {
    std::uint64_t order = 0;
    for (unsigned slot = 0; slot < kMaxWidth; ++slot) {
      order |= std::uint64_t{1} << slot << 8 * Policy::place(slot, (1U << kMaxWidth) - 1, slot);
    }
    return order;
  }
  /// `order` restricted to the slots of the mask `remaining`.
  std::uint64_t ordered(unsigned remaining) const { return order & bits_of_mask(remaining); }
  /// All bits of `order` that may stand for the slots of a mask.
  static std::uint64_t bits_of_mask(unsigned mask) { return kOnes * mask; }
  /// All bits of `order` that may stand for `slot`.
  static std::uint64_t bits_of(unsigned slot) { return kOnes << slot; }
  /// Inverse of ordered().
  static unsigned mask_of(std::uint64_t ordered) { return static_cast<unsigned>(ordered * kOnes >> 56); }
  /// The first slot of a result of ordered() that is not 0.
  static unsigned first_of(std::uint64_t ordered) { return static_cast<unsigned>(std::countr_zero(ordered)) & 7; }
  /// Number of slots in `remaining` expected before `slot`.
  unsigned rank_of(unsigned remaining, unsigned slot) const {
    const std::uint64_t place = order & kOnes << slot;
    unsigned rank = 0;
    for (std::uint64_t left = ordered(remaining) & (place - 1); left != 0; left &= left - 1) ++rank;
    return rank;
  }
  /// Inverse of rank_of(): the slot in `remaining` with this rank, which must be below their number.
  unsigned slot_at(unsigned remaining, unsigned rank) const {
    std::uint64_t left = ordered(remaining);
    for (; rank != 0; --rank) left &= left - 1;
    return static_cast<unsigned>(std::countr_zero(left)) & 7;
  }
  /// Moves `slot`, which was popped although others in `remaining` were expected first, before the first of them: of
  /// the order 2 0 1 3 and `remaining` 0, 1 and 3, slot 3 moves before slot 0, and the order is 2 3 0 1.
  void move_up(unsigned remaining, unsigned slot) {
    const auto to = static_cast<unsigned>(std::countr_zero(ordered(remaining))) & ~7U;  // bits of the lower bytes
    const std::uint64_t place = order & kOnes << slot;
    const std::uint64_t below = (std::uint64_t{1} << to) - 1;
    const std::uint64_t passed = order & (place - 1) & ~below;
    const std::uint64_t behind = order & ~(place | (place - 1));
    order = behind | passed << 8 | std::uint64_t{1} << (to + slot) | (order & below);
  }

 private:
  static constexpr std::uint64_t kOnes = 0x0101010101010101;
  static constexpr std::uint64_t kDiagonal = 0x8040201008040201;
};
static_assert(sizeof(NodeModel) == 64);

/// The children of one parent that are still on the stack.
struct StackFrame {
  std::uint32_t parent = 0;
  InstancePath path;
  std::uint32_t remaining = 0;  ///< mask of slots, not empty
};

/// Pseudo parents, each with one root as its only child, indexed by root number (InstanceLevels); then the group's
/// nodes.
class GroupModel {
 public:
  static constexpr std::uint32_t kRootParent = InstanceLevels::kRoot;
  static constexpr std::uint32_t kBlasRootParent = InstanceLevels::kBlasRoot;

  /// Starts a new group without nodes.
  void begin(const Header& header, NodeKind root_kind);
  /// Adds a node and returns its index. Throws std::invalid_argument if it breaks a rule (child kinds, node image).
  /// Invalidates references to nodes.
  std::uint32_t add(const NodeDefinition& node, const NodeShape& shape);
  /// Adds `count` nodes, to be filled by set(). Invalidates references to nodes.
  void add_unset(std::size_t count) { nodes_.resize(nodes_.size() + count); }
  /// Fills a node of add_unset(). Throws like add().
  void set(std::uint32_t index, const NodeDefinition& node, const NodeShape& shape);
  /// Shape of any node of the trace, whether it is in the model or not.
  const NodeShape& shape(const NodeDefinition& node) { return shapes_.shape_of(node); }
  ShapeTable& shapes() { return shapes_; }

  std::size_t size() const { return nodes_.size(); }
  NodeModel* nodes() { return nodes_.data(); }
  NodeModel& operator[](std::uint32_t index) { return nodes_[index]; }
  const NodeModel& operator[](std::uint32_t index) const { return nodes_[index]; }
  const InstanceLevels& levels() const { return levels_; }
  std::uint32_t first_node() const { return levels_.roots(); }  ///< first index after the pseudo parents

 private:
  std::vector<NodeModel> nodes_;
  InstanceLevels levels_;
  std::uint64_t image_units_ = 0;
  std::uint64_t internal_units_ = 0;
  std::uint64_t first_order_ = 0;  ///< initial NodeModel::order
  ShapeTable shapes_;
};

}  // namespace grtx::traces
