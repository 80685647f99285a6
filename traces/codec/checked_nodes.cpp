// SPDX-License-Identifier: Apache-2.0
#include "grtx/traces/codec/checked_nodes.h"

#include <algorithm>

namespace grtx::traces {
namespace {

CheckedNode pseudo_parent(std::uint64_t child) {
  CheckedNode node;
  node.child_base = static_cast<std::uint32_t>(child);
  node.child_count = 1;
  return node;
}

}  // namespace

const char* CheckedNodes::take(const Header& header, const std::vector<NodeDefinition>& dictionary) {
  const NodeSizes sizes = header.node_sizes();
  const std::uint64_t image_units = header.node_image_bytes / sizes.unit();
  const std::uint64_t node_units = sizes.units(NodeKind::internal);
  shapes_.set_sizes(sizes);
  levels_ = InstanceLevels(header);
  nodes_.resize(first_node() + dictionary.size());
  nodes_[GroupModel::kRootParent] = pseudo_parent(header.root / sizes.unit());
  nodes_[GroupModel::kBlasRootParent] = pseudo_parent(header.blas_root / sizes.unit());
  nodes_[GroupModel::kBlasRootParent].internal_mask = header.blas_root_is_leaf ? 0 : 1;
  for (std::size_t object = 0; object < header.object_roots.size(); ++object) {
    CheckedNode& parent = nodes_[InstanceLevels::kFirstObjectRoot + object];
    parent = pseudo_parent(header.object_roots[object] / sizes.unit());
    parent.internal_mask = 1;
  }
  std::int64_t last_address = -1;
  CheckedNode* next = nodes_.data() + first_node();
  for (const NodeDefinition& definition : dictionary) {
    if (definition.address <= last_address) return "nodes must ascend by address";
    last_address = definition.address;
    const NodeShape& shape = shapes_.shape_of(definition);
    if (shape.fault != nullptr) return shape.fault;
    if (definition.address + node_units > image_units ||
        static_cast<std::uint64_t>(definition.child_base) + shape.units > image_units) {
      return "a node and its children must lie in the node image";
    }
    CheckedNode& node = *next++;
    node.address = definition.address;
    node.child_base = definition.child_base;
    node.child_count = shape.child_count;
    node.internal_mask = shape.internal_mask;
    node.instance_mask = shape.instance_mask;
    node.wide_mask = shape.wide_mask;
    node.wide_leaves = shape.wide_leaves;
    node.visited = false;
  }
  return nullptr;
}

bool CheckedNodes::all_visited() const {
  return std::all_of(nodes_.begin() + first_node(), nodes_.end(), [](const CheckedNode& node) { return node.visited; });
}

}  // namespace grtx::traces
