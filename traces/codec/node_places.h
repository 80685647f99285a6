// SPDX-License-Identifier: Apache-2.0
// Checks across groups that the internal nodes in their dictionaries are consistent parts of one node image.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>

#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::traces {

/// Not thread-safe: use one per thread and merge them at the end.
class NodePlaces {
 public:
  explicit NodePlaces(const Header& header) : sizes_(header.node_sizes()), wide_leaves_(header.wide_leaves) {}
  void add(const RayGroup& group);
  void add(const NodePlaces& other);
  /// Throws Error{file, "group G node A", rule} if two groups define a node differently, or if the children of two
  /// nodes overlap. If there are several faults, the one with the lowest address. Throws, too, if there are more wide
  /// leaves than the header says.
  void check(const std::string& file) const;

 private:
  struct Place {
    std::uint32_t group = 0;       ///< lowest group that visited it
    std::uint32_t child_base = 0;  ///< units
    std::uint32_t child_end = 0;   ///< units
    std::uint32_t kinds = 0;       ///< four bits per child
    std::uint32_t contradicted_by = kNobody;
    bool same_node(const Place& o) const {
      return child_base == o.child_base && child_end == o.child_end && kinds == o.kinds;
    }
  };
  static constexpr std::uint32_t kNobody = ~std::uint32_t{0};

  void add(std::uint32_t address, const Place& place);

  NodeSizes sizes_;
  std::uint64_t wide_leaves_;
  std::unordered_map<std::uint32_t, Place> places_;  ///< address in units -> place
};

}  // namespace grtx::traces
