#include "traces/group_model.h"

#include <algorithm>
#include <stdexcept>

namespace grtx::traces {
namespace {

bool is_known_kind(NodeKind kind) {
  return kind == NodeKind::internal || kind == NodeKind::instance || kind == NodeKind::procedural ||
         kind == NodeKind::triangle;
}

NodeModel pseudo_parent(std::uint64_t child_address, NodeKind kind) {
  NodeModel model;
  model.child_base = static_cast<std::uint32_t>(child_address / kNodeUnit);
  model.child_count = 1;
  model.internal_mask = kind == NodeKind::internal ? 1 : 0;
  model.instance_mask = kind == NodeKind::instance ? 1 : 0;
  model.links.fill(NodeModel::kUnknownLink);
  return model;
}

}  // namespace

unsigned NodeModel::rank_of(unsigned remaining, unsigned slot) {
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

unsigned NodeModel::slot_at(unsigned remaining, unsigned rank) {
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
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const NodeDefinition& node = nodes[i];
    if (const std::string fault = definition_fault(header, node); !fault.empty()) throw std::invalid_argument(fault);
    if (i > 0 && node.address <= nodes[i - 1].address) throw std::invalid_argument("nodes must ascend by address");
    NodeModel& model = nodes_[i];
    model = NodeModel{};
    addresses_[i] = node.address;
    model.child_base = node.child_base;
    model.child_count = node.child_count;
    model.links.fill(NodeModel::kUnknownLink);
    unsigned offset = 0;
    for (unsigned slot = 0; slot < node.child_count; ++slot) {
      const NodeKind kind = node.child_kinds[slot];
      model.offsets |= offset << (4 * slot);
      offset += static_cast<unsigned>(node_bytes(kind, header.bvh_width) / kNodeUnit);
      if (kind == NodeKind::internal) model.internal_mask = static_cast<std::uint8_t>(model.internal_mask | 1U << slot);
      if (kind == NodeKind::instance) model.instance_mask = static_cast<std::uint8_t>(model.instance_mask | 1U << slot);
    }
  }
  nodes_[nodes.size()] = pseudo_parent(header.root, root_kind);
  const NodeKind blas_kind = header.blas_root_is_leaf ? NodeKind::procedural : NodeKind::internal;
  nodes_[nodes.size() + 1] = pseudo_parent(header.blas_root, blas_kind);
  blas_begin_ = header.two_level ? static_cast<std::uint32_t>(header.blas_base / kNodeUnit) : 0xFFFFFFFF;
}

std::uint32_t GroupModel::find(std::uint32_t address) const {
  const auto found = std::lower_bound(addresses_.begin(), addresses_.end(), address);
  if (found == addresses_.end() || *found != address) return NodeModel::kUnknownLink;
  return static_cast<std::uint32_t>(found - addresses_.begin());
}

std::uint64_t children_bytes(const NodeDefinition& node, unsigned bvh_width) {
  std::uint64_t sum = 0;
  for (unsigned slot = 0; slot < node.child_count; ++slot) sum += node_bytes(node.child_kinds[slot], bvh_width);
  return sum;
}

std::string definition_fault(const Header& header, const NodeDefinition& node) {
  if (node.child_count < 1 || node.child_count > header.bvh_width) return "a node must have 1..bvh_width children";
  for (unsigned slot = 0; slot < kMaxWidth; ++slot) {
    if (!is_known_kind(node.child_kinds[slot])) return "a child must be of a known kind";
    if (slot >= node.child_count && node.child_kinds[slot] != NodeKind::internal) {
      return "an unused child slot must be of kind internal";
    }
  }
  const auto fits = [&](std::uint64_t unit, std::uint64_t bytes) {
    return bytes <= header.node_image_bytes && unit * kNodeUnit <= header.node_image_bytes - bytes;
  };
  if (!fits(node.address, internal_bytes(header.bvh_width)) ||
      !fits(node.child_base, children_bytes(node, header.bvh_width))) {
    return "a node and its children must lie in the node image";
  }
  return "";
}

}  // namespace grtx::traces
