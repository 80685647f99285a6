// SPDX-License-Identifier: Apache-2.0
// The nodes that chosen rays of a warp visited, and their children, numbered for the page of `grtx ray`.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::report {

inline constexpr std::uint32_t kNoGaussian = ~std::uint32_t{0};

/// A node that a ray visited, or a child of one.
struct RayNode {
  std::uint32_t units = 0;  ///< address in units of the node layout
  traces::NodeKind kind = traces::NodeKind::internal;
  std::uint32_t parent = 0;       ///< node number + 1; 0: a root
  std::uint32_t first_child = 0;  ///< node number + 1; siblings follow in slot order; 0: not visited, or a leaf
  /// Gaussian of an instance or primitive leaf, kNoGaussian if unknown. For a leaf of a scene TLAS: number of the first
  /// Gaussian of its object.
  std::uint32_t gaussian = kNoGaussian;
  // Only if the scene is given.
  bool boxed = false;
  std::array<float, 6> box{};  ///< lower x, y, z, upper x, y, z; inside a BLAS in the unit sphere's frame
};

/// The nodes of the chosen rays of a group, numbered from 0.
class RayNodes {
 public:
  /// Throws Error if two nodes of the group have one child: the nodes are no tree. `file`: the trace.
  RayNodes(const std::string& file, const traces::Header& header, const traces::RayGroup& group,
           const std::vector<unsigned>& lanes);

  std::vector<RayNode>& nodes() { return nodes_; }
  const std::vector<RayNode>& nodes() const { return nodes_; }
  std::uint32_t number(std::uint32_t units) const { return numbers_.at(units); }
  const RayNode& operator[](std::uint32_t number) const { return nodes_[number]; }
  /// Slot of a node among its siblings. The node must not be a root.
  unsigned slot(std::uint32_t number) const;

 private:
  bool add(std::uint32_t units, traces::NodeKind kind, std::uint32_t parent);

  std::vector<RayNode> nodes_;
  std::map<std::uint32_t, std::uint32_t> numbers_;
};

/// Address in units of the node that an event is about.
inline std::uint32_t units_of(const traces::RayGroup& group, const traces::Event& event) {
  return event.kind() == traces::EventKind::visit_internal ? group.nodes[event.node].address : event.node;
}

}  // namespace grtx::report
