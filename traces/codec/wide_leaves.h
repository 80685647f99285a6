// SPDX-License-Identifier: Apache-2.0
// Addresses of the wide leaves among the children of a group's internal nodes, to find the events that visit one.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "grtx/traces/event.h"
#include "grtx/traces/node_layout.h"

namespace grtx::traces {

class WideLeaves {
 public:
  void take(const std::vector<NodeDefinition>& nodes, const NodeSizes& sizes) {
    addresses_.clear();
    if (!sizes.wide_leaves()) return;
    for (const NodeDefinition& node : nodes) {
      std::uint32_t child = node.child_base;
      for (unsigned slot = 0; slot < node.child_count; ++slot) {
        if (is_wide(node.child_kinds[slot])) addresses_.push_back(child);
        child += sizes.units(node.child_kinds[slot]);
      }
    }
    std::sort(addresses_.begin(), addresses_.end());
  }
  bool empty() const { return addresses_.empty(); }
  bool contains(std::uint32_t address) const {
    return std::binary_search(addresses_.begin(), addresses_.end(), address);
  }

 private:
  std::vector<std::uint32_t> addresses_;
};

}  // namespace grtx::traces
