// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/ray/ray_nodes.h"

#include <set>

#include "grtx/base/error.h"

namespace grtx::report {

using traces::Event;
using traces::EventKind;
using traces::NodeKind;

RayNodes::RayNodes(const std::string& file, const traces::Header& header, const traces::RayGroup& group,
                   const std::vector<unsigned>& lanes) {
  const auto require_tree = [&](bool added) {
    if (!added) throw Error(file, "group " + std::to_string(group.index), "no node may be a child of two");
  };
  const traces::NodeSizes sizes = header.node_sizes();
  std::vector<bool> visited(group.nodes.size());
  std::set<std::uint32_t> others;
  for (const unsigned lane : lanes) {
    for (const Event& event : group.rays[lane].events) {
      if (event.kind() == EventKind::visit_internal) {
        visited[event.node] = true;
      } else {
        others.insert(event.node);
      }
    }
  }
  std::vector<std::uint32_t> roots = {static_cast<std::uint32_t>(header.root / sizes.unit())};
  if (header.two_level) roots.push_back(static_cast<std::uint32_t>(header.blas_root / sizes.unit()));
  for (const std::uint64_t root : header.object_roots) roots.push_back(static_cast<std::uint32_t>(root / sizes.unit()));
  const NodeKind leaf = traces::has_procedural_leaves(header.accel) ? NodeKind::procedural : NodeKind::triangle;
  for (const std::uint32_t root : roots) {
    require_tree(add(root, others.contains(root) ? leaf : NodeKind::internal, 0));
  }
  std::map<std::uint32_t, std::uint32_t> first;  // address of a node -> number + 1 of its first child
  for (std::size_t i = 0; i < visited.size(); ++i) {
    if (!visited[i]) continue;
    const traces::NodeDefinition& node = group.nodes[i];
    first[node.address] = static_cast<std::uint32_t>(nodes_.size()) + 1;
    std::uint32_t child = node.child_base;
    for (unsigned slot = 0; slot < node.child_count; ++slot) {
      require_tree(add(child, node.child_kinds[slot], node.address));
      child += sizes.units(node.child_kinds[slot]);
    }
  }
  for (RayNode& node : nodes_) {
    if (node.parent != 0) node.parent = numbers_.at(node.parent) + 1;
    const auto found = first.find(node.units);
    if (found != first.end()) node.first_child = found->second;
  }
}

/// parent: address of the parent in units; 0 for a root, as no node lies at address 0 (the headers do). Returns false
/// if the node is there already.
bool RayNodes::add(std::uint32_t units, NodeKind kind, std::uint32_t parent) {
  if (!numbers_.emplace(units, static_cast<std::uint32_t>(nodes_.size())).second) return false;
  RayNode& node = nodes_.emplace_back();
  node.units = units;
  node.kind = kind;
  node.parent = parent;
  return true;
}

unsigned RayNodes::slot(std::uint32_t number) const {
  return number + 1 - nodes_[nodes_[number].parent - 1].first_child;
}

}  // namespace grtx::report
