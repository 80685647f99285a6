// Where the nodes of a trace lie, over all of its groups: each group brings the internal nodes that it visited, and all
// must be parts of one tree image.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>

#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::traces {

/// Not thread-safe: one a thread, merged at the end.
class NodePlaces {
 public:
  explicit NodePlaces(const Header& header) : sizes_(header.node_sizes()) {}
  void add(const RayGroup& group);
  void add(const NodePlaces& other);
  /// Throws Error{file, "group G node A", rule} when two groups say different things of a node, or when children of two
  /// nodes overlap. Of several faults the one of the lowest address.
  void check(const std::string& file) const;

 private:
  struct Place {
    std::uint32_t group = 0;       ///< the first that visited it
    std::uint32_t child_base = 0;  ///< units
    std::uint32_t child_end = 0;   ///< units
    std::uint32_t kinds = 0;       ///< two bits a child
    std::uint32_t contradicted_by = kNobody;
    bool same_node(const Place& o) const {
      return child_base == o.child_base && child_end == o.child_end && kinds == o.kinds;
    }
  };
  static constexpr std::uint32_t kNobody = ~std::uint32_t{0};

  void add(std::uint32_t address, const Place& place);

  NodeSizes sizes_;
  std::unordered_map<std::uint32_t, Place> places_;  ///< by address in units
};

}  // namespace grtx::traces
