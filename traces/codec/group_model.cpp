// SPDX-License-Identifier: Apache-2.0
#include "grtx/traces/codec/group_model.h"

#include <stdexcept>

#include "grtx/traces/orders/child_order.h"

namespace grtx::traces {
namespace {

NodeModel pseudo_parent(std::uint64_t child, NodeKind kind) {
  NodeModel model;
  model.child_base = static_cast<std::uint32_t>(child);
  model.child_count = 1;
  model.internal_mask = kind == NodeKind::internal ? 1 : 0;
  model.instance_mask = kind == NodeKind::instance ? 1 : 0;
  return model;
}

}  // namespace

void GroupModel::begin(const Header& header, NodeKind root_kind) {
  const NodeSizes sizes = header.node_sizes();
  shapes_.set_sizes(sizes);
  first_order_ = with_child_order(header.child_order, [](auto policy) { return NodeModel::order_of(policy); });
  image_units_ = header.node_image_bytes / sizes.unit();
  internal_units_ = sizes.units(NodeKind::internal);
  nodes_.clear();
  nodes_.push_back(pseudo_parent(header.root / sizes.unit(), root_kind));
  const NodeKind blas_kind = header.blas_root_is_leaf ? NodeKind::procedural : NodeKind::internal;
  nodes_.push_back(pseudo_parent(header.blas_root / sizes.unit(), blas_kind));
  for (const std::uint64_t root : header.object_roots) {
    nodes_.push_back(pseudo_parent(root / sizes.unit(), NodeKind::internal));
  }
  levels_ = InstanceLevels(header);
}

void GroupModel::set(std::uint32_t index, const NodeDefinition& node, const NodeShape& shape) {
  if (shape.fault != nullptr) throw std::invalid_argument(shape.fault);
  if (node.address + internal_units_ > image_units_ ||
      static_cast<std::uint64_t>(node.child_base) + shape.units > image_units_) {
    throw std::invalid_argument("a node and its children must lie in the node image");
  }
  NodeModel& model = nodes_[index];
  model.order = first_order_;
  model.child_base = node.child_base;
  model.offsets = shape.offsets;
  model.child_count = shape.child_count;
  model.internal_mask = shape.internal_mask;
  model.instance_mask = shape.instance_mask;
  model.wide_mask = shape.wide_mask;
}

std::uint32_t GroupModel::add(const NodeDefinition& node, const NodeShape& shape) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  set(index, node, shape);
  return index;
}

}  // namespace grtx::traces
