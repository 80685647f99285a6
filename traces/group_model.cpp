#include "traces/group_model.h"

#include <algorithm>
#include <stdexcept>

namespace grtx::traces {
namespace {

NodeModel pseudo_parent(std::uint64_t child_address, NodeKind kind) {
  NodeModel model;
  model.child_base = static_cast<std::uint32_t>(child_address / kNodeUnit);
  model.child_count = 1;
  model.internal_mask = kind == NodeKind::internal ? 1 : 0;
  model.instance_mask = kind == NodeKind::instance ? 1 : 0;
  return model;
}

}  // namespace

unsigned NodeModel::rank_behind_first(unsigned remaining, unsigned slot) {
  unsigned rank = 0;
  unsigned first = kMaxWidth;
  for (unsigned place = 0;; ++place) {
    const unsigned candidate = priority >> (4 * place) & 7;
    if (candidate == slot) {
      if (rank > 0) move_up(place, first);
      return rank;
    }
    if ((remaining >> candidate & 1) != 0) {
      if (rank == 0) first = place;
      ++rank;
    }
  }
}

unsigned NodeModel::slot_behind_first(unsigned remaining, unsigned rank) {
  unsigned seen = 0;
  unsigned first = kMaxWidth;
  for (unsigned place = 0;; ++place) {
    const unsigned candidate = priority >> (4 * place) & 7;
    if ((remaining >> candidate & 1) == 0) continue;
    if (seen == rank) {
      if (rank > 0) move_up(place, first);
      return candidate;
    }
    if (seen == 0) first = place;
    ++seen;
  }
}

void NodeModel::move_up(unsigned from, unsigned to) {
  const std::uint64_t places = priority;
  const std::uint64_t moved = places >> (4 * from) & 0xF;
  const std::uint64_t below = (1ULL << (4 * to)) - 1;
  const std::uint64_t up_to_from = (1ULL << (4 * (from + 1))) - 1;
  const std::uint64_t between = places & ((1ULL << (4 * from)) - 1) & ~below;
  priority = static_cast<std::uint32_t>((places & below) | moved << (4 * to) | between << 4 | (places & ~up_to_from));
}

void GroupModel::build(const Header& header, const std::vector<NodeDefinition>& nodes, NodeKind root_kind) {
  nodes_.resize(nodes.size() + 2);
  addresses_.resize(nodes.size());
  shapes_.set_width(header.bvh_width);
  const std::uint64_t image_units = header.node_image_bytes / kNodeUnit;
  const std::uint64_t internal_units = internal_bytes(header.bvh_width) / kNodeUnit;
  std::int64_t last_address = -1;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const NodeDefinition& node = nodes[i];
    const NodeShape& shape = shapes_.of(node);
    if (shape.fault != nullptr) throw std::invalid_argument(shape.fault);
    if (node.address + internal_units > image_units ||
        static_cast<std::uint64_t>(node.child_base) + shape.units > image_units) {
      throw std::invalid_argument("a node and its children must lie in the node image");
    }
    if (node.address <= last_address) throw std::invalid_argument("nodes must ascend by address");
    last_address = node.address;
    addresses_[i] = node.address;
    NodeModel& model = nodes_[i];
    model = NodeModel{};
    model.child_base = node.child_base;
    model.offsets = shape.offsets;
    model.child_count = shape.child_count;
    model.internal_mask = shape.internal_mask;
    model.instance_mask = shape.instance_mask;
    model.wide_mask = shape.wide_mask;
  }
  nodes_[nodes.size()] = pseudo_parent(header.root, root_kind);
  const NodeKind blas_kind = header.blas_root_is_leaf ? NodeKind::procedural : NodeKind::internal;
  nodes_[nodes.size() + 1] = pseudo_parent(header.blas_root, blas_kind);
  blas_begin_ = header.two_level ? static_cast<std::uint32_t>(header.blas_base / kNodeUnit) : 0xFFFFFFFF;
}

std::uint32_t GroupModel::find(std::uint32_t address) const {
  const auto found = std::lower_bound(addresses_.begin(), addresses_.end(), address);
  if (found == addresses_.end() || *found != address) return kUnknownLink;
  return static_cast<std::uint32_t>(found - addresses_.begin());
}

}  // namespace grtx::traces
