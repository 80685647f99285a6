// SPDX-License-Identifier: Apache-2.0
// The checker's copy of a group's nodes: small, so that all nodes of a group stay in the host's caches.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/traces/codec/group_model.h"
#include "grtx/traces/codec/node_shape.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::traces {

/// The data that the rules need of a dictionary node, or of the pseudo parent of a root.
struct alignas(16) CheckedNode {
  std::uint32_t address = 0;     ///< in units
  std::uint32_t child_base = 0;  ///< in units
  std::uint8_t child_count = 0;
  std::uint8_t internal_mask = 0;  ///< as in NodeShape
  std::uint8_t instance_mask = 0;  ///< as in NodeShape
  std::uint8_t wide_mask = 0;      ///< as in NodeShape
  std::uint8_t wide_leaves = 0;    ///< as in NodeShape
  bool visited = false;

  std::uint32_t child_address(unsigned slot) const {
    return child_base + slot + bits_of_byte(wide_mask & ((1U << slot) - 1));
  }
  /// Slot in mask `remaining` of the child at address `child`; kMaxWidth if there is none.
  unsigned slot_of(unsigned remaining, std::uint32_t child) const {
    const std::uint32_t offset = child - child_base;
    if (offset > 15) return kMaxWidth;
    const unsigned slot = kSlotAtOffset[wide_mask][offset];
    return (remaining >> slot & 1) != 0 ? slot : kMaxWidth;
  }
};

/// Pseudo parents, then the dictionary, with the indices of GroupModel. Reuses its memory for the next group.
class CheckedNodes {
 public:
  /// Replaces all nodes. Returns the rule that the dictionary breaks, or null.
  const char* take(const Header& header, const std::vector<NodeDefinition>& dictionary);

  CheckedNode* begin() { return nodes_.data(); }
  CheckedNode& operator[](std::uint32_t index) { return nodes_[index]; }
  const CheckedNode& operator[](std::uint32_t index) const { return nodes_[index]; }
  std::uint32_t dictionary_size() const { return static_cast<std::uint32_t>(nodes_.size()) - first_node(); }
  std::uint32_t first_node() const { return levels_.roots(); }
  /// Whether every dictionary node has been visited.
  bool all_visited() const;
  const InstanceLevels& levels() const { return levels_; }

 private:
  ShapeTable shapes_;
  std::vector<CheckedNode> nodes_;
  InstanceLevels levels_;
};

}  // namespace grtx::traces
