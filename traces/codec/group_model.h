// What encoder and decoder of a group know in common while they replay its events: where children lie, and what each
// node did last time. A ray that restarts, or the ray of the next lane, mostly repeats what was seen, and what repeats
// takes no bytes.
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

/// A node (or a pseudo parent, see GroupModel) with what the coder remembers of it: one cache line.
struct alignas(64) NodeModel {
  static constexpr std::uint32_t kUnknownLink = 0;  ///< the root's pseudo parent, which is nobody's child
  /// The slots in the order in which they are expected to be popped, first the lowest byte, each as the bit of its
  /// mask.
  std::uint64_t order = kDiagonal;
  std::array<std::uint8_t, kMaxWidth> last_op{};  ///< symbol of the child's last pop
  std::uint32_t child_base = 0;                   ///< in units
  std::uint32_t offsets = 0;                      ///< as in NodeShape
  std::array<std::uint32_t, kMaxWidth> links{};   ///< index of the node in each slot, if it is internal and known
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

  /// The order that a child order (traces/orders/child_order.h) begins with: all slots are hit, entered in slot order.
  template <typename Policy>
  static constexpr std::uint64_t order_of(Policy) {
    std::uint64_t order = 0;
    for (unsigned slot = 0; slot < kMaxWidth; ++slot) {
      order |= std::uint64_t{1} << slot << 8 * Policy::place(slot, (1U << kMaxWidth) - 1, slot);
    }
    return order;
  }
  /// The slots of the mask `remaining` in the order in which they are expected, as bits in `order`.
  std::uint64_t ordered(unsigned remaining) const { return order & bits_of_mask(remaining); }
  /// The bits that stand for the slots of a mask, wherever they come in the order.
  static std::uint64_t bits_of_mask(unsigned mask) { return kOnes * mask; }
  /// The bits that stand for `slot`, wherever it comes in the order.
  static std::uint64_t bits_of(unsigned slot) { return kOnes << slot; }
  /// Undoes ordered().
  static unsigned mask_of(std::uint64_t ordered) { return static_cast<unsigned>(ordered * kOnes >> 56); }
  /// The first of them, which are not none.
  static unsigned first_of(std::uint64_t ordered) { return static_cast<unsigned>(std::countr_zero(ordered)) & 7; }
  /// How many slots of `remaining` are expected before `slot`.
  unsigned rank_of(unsigned remaining, unsigned slot) const {
    const std::uint64_t place = order & kOnes << slot;
    unsigned rank = 0;
    for (std::uint64_t left = ordered(remaining) & (place - 1); left != 0; left &= left - 1) ++rank;
    return rank;
  }
  /// The slot of `remaining` with `rank` (below the number of slots in it) of them before it.
  unsigned slot_at(unsigned remaining, unsigned rank) const {
    std::uint64_t left = ordered(remaining);
    for (; rank != 0; --rank) left &= left - 1;
    return static_cast<unsigned>(std::countr_zero(left)) & 7;
  }
  /// `slot`, which was popped although others of `remaining` were expected first, moves before the first of them.
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

/// An entry of a checkpoint buffer: one child of one node, reached through its instances.
struct NodeReference {
  std::uint32_t parent = 0;  ///< index into the model
  std::uint32_t slot = 0;
  InstancePath path;
};

/// Children of one parent that are on the stack and not popped yet.
struct StackFrame {
  std::uint32_t parent = 0;
  InstancePath path;
  std::uint32_t remaining = 0;  ///< mask of slots, not empty
};

/// Pseudo parents, each of whose only child is a root, by its number (InstanceLevels); then the nodes of a group.
class GroupModel {
 public:
  static constexpr std::uint32_t kRootParent = InstanceLevels::kRoot;
  static constexpr std::uint32_t kBlasRootParent = InstanceLevels::kBlasRoot;

  /// Forgets all nodes.
  void begin(const Header& header, NodeKind root_kind);
  /// Throws std::invalid_argument when the node breaks a rule (child kinds, node image). References to nodes become
  /// invalid.
  std::uint32_t add(const NodeDefinition& node, const NodeShape& shape);
  /// Adds `count` nodes, which set() then describes. References to nodes become invalid.
  void add_unset(std::size_t count) { nodes_.resize(nodes_.size() + count); }
  /// Throws as add() does.
  void set(std::uint32_t index, const NodeDefinition& node, const NodeShape& shape);
  /// Shape of any node of the trace.
  const NodeShape& shape(const NodeDefinition& node) { return shapes_.of(node); }
  ShapeTable& shapes() { return shapes_; }

  std::size_t size() const { return nodes_.size(); }
  NodeModel* nodes() { return nodes_.data(); }
  NodeModel& operator[](std::uint32_t index) { return nodes_[index]; }
  const NodeModel& operator[](std::uint32_t index) const { return nodes_[index]; }
  const InstanceLevels& levels() const { return levels_; }
  std::uint32_t first_node() const { return levels_.roots(); }  ///< index of the first that is no pseudo parent

 private:
  std::vector<NodeModel> nodes_;
  InstanceLevels levels_;
  std::uint64_t image_units_ = 0;
  std::uint64_t internal_units_ = 0;
  std::uint64_t first_order_ = 0;  ///< NodeModel::order of a node not visited yet
  ShapeTable shapes_;
};

}  // namespace grtx::traces
