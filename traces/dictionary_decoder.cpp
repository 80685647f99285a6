#include "traces/dictionary_decoder.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <stdexcept>

#include "traces/group_codec.h"
#include "traces/node_shape.h"

namespace grtx::traces {
namespace {

constexpr std::uint64_t kMaxU32 = std::numeric_limits<std::uint32_t>::max();

// Bit i moves to bit 2 i.
unsigned spread_bits(unsigned byte) { return scatter_bits(byte, 0x5555); }

}  // namespace

void DictionaryDecoder::take(const Header& header, unsigned flags, std::vector<NodeDefinition>& nodes) {
  tree_masks_.assign(nodes.size(), 0);
  tree_order_.clear();
  last_address_ = -1;
  try {
    if (flags == 0) {
      take_by_address(nodes);
    } else {
      take_tree(header, flags, nodes);
    }
  } catch (const std::invalid_argument& fault) {
    throw Malformed(fault.what());
  }
  take_first_hits(nodes.size());
}

/// In ascending order: model and dictionary count alike.
void DictionaryDecoder::add(const NodeDefinition& node, const NodeShape& shape) {
  if (static_cast<std::int64_t>(node.address) <= last_address_) throw Malformed("nodes must ascend by address");
  last_address_ = node.address;
  model_.add(node, shape);
}

void DictionaryDecoder::take_by_address(std::vector<NodeDefinition>& nodes) {
  std::uint32_t address = 0;
  std::int64_t predicted_children = 0;
  ByteReader& addresses = readers_[Column::node_address];
  ByteReader& children = readers_[Column::node_children];
  for (NodeDefinition& node : nodes) {
    address = checked_u32(addresses, address + static_cast<std::int64_t>(addresses.varint(kMaxU32)));
    node.address = address;
    node.child_base = checked_u32(children, predicted_children + unzigzag(children.varint(4 * kMaxU32)));
    take_shape(node);
    const NodeShape& shape = model_.shape(node);
    predicted_children = static_cast<std::int64_t>(node.child_base + shape.units);
    add(node, shape);
  }
}

void DictionaryDecoder::take_tree(const Header& header, unsigned flags, std::vector<NodeDefinition>& nodes) {
  ByteReader& children = readers_[Column::node_children];
  ByteReader& masks = readers_[Column::node_tree];
  std::size_t next = 0;
  std::int64_t end = 0;
  links_.clear();
  const auto enter = [&](std::int64_t address, std::uint32_t parent, unsigned slot) {
    if (next == nodes.size()) masks.fail("names more nodes than there are");
    nodes[next].address = checked_u32(masks, address);
    const auto index = static_cast<std::uint32_t>(next++);
    walk_.push_back(index);
    links_.push_back({parent, slot});
    return index;
  };
  for (const unsigned root : {kNodesHoldRoot, kNodesHoldBlasRoot}) {
    if ((flags & root) == 0) continue;
    const bool first = root == kNodesHoldRoot;
    walk_.clear();
    enter(static_cast<std::int64_t>((first ? header.root : header.blas_root) / kNodeUnit),
          first ? GroupModel::kRootParent : GroupModel::kBlasRootParent, 0);
    bool skipped = true;
    while (!walk_.empty()) {
      const std::uint32_t index = walk_.back();
      walk_.pop_back();
      if (index == kSkipped) {
        skipped = true;
        continue;
      }
      NodeDefinition& node = nodes[index];
      const std::int64_t gap = skipped ? static_cast<std::int64_t>(children.varint(kMaxU32)) : 0;
      skipped = false;
      node.child_base = checked_u32(children, end + gap);
      take_shape(node);
      const NodeShape& shape = model_.shape(node);
      if (shape.fault != nullptr) throw Malformed(shape.fault);
      end = static_cast<std::int64_t>(node.child_base) + shape.units;
      tree_order_.push_back(index);
      if (shape.internal_mask == 0) continue;
      const unsigned visited = masks.u8();
      if ((visited & ~unsigned{shape.internal_mask}) != 0) masks.fail("names a child that is not internal");
      tree_masks_[index] = static_cast<std::uint8_t>(visited);
      const std::size_t first_child = walk_.size();
      for (unsigned left = shape.internal_mask; left != 0; left &= left - 1) {
        const auto slot = static_cast<unsigned>(std::countr_zero(left));
        if ((visited >> slot & 1) == 0) {
          walk_.push_back(kSkipped);
          continue;
        }
        const unsigned offset = shape.offsets >> (4 * slot) & 0xF;
        enter(static_cast<std::int64_t>(node.child_base) + offset, GroupModel::kFirstNode + index, slot);
      }
      std::reverse(walk_.begin() + static_cast<std::ptrdiff_t>(first_child), walk_.end());
    }
  }
  if (next != nodes.size()) masks.fail("names fewer nodes than there are");
  for (const NodeDefinition& node : nodes) add(node, model_.shape(node));
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    model_[links_[i].parent].links[links_[i].slot] = GroupModel::kFirstNode + i;
  }
}

// In the order in which the other columns list the nodes.
void DictionaryDecoder::take_first_hits(std::size_t nodes) {
  ByteReader& hits = readers_[Column::node_hits];
  for (std::uint32_t i = 0; i < nodes; ++i) {
    const std::uint32_t index = tree_order_.empty() ? i : tree_order_[i];
    NodeModel& node = model_[GroupModel::kFirstNode + index];
    node.last_hits = hits.u8() ^ tree_masks_[index];
    if (node.last_hits >> node.child_count != 0) hits.fail("names a child that is not there");
  }
}

void DictionaryDecoder::take_shape(NodeDefinition& node) {
  ByteReader& shapes = readers_[Column::node_shape];
  const unsigned shape = shapes.u8();
  const unsigned leaf = shape >> 4 & 3;
  const bool mixed = (shape & kShapeMixed) != 0;
  const bool irregular = (shape & kShapeIrregular) != 0;
  node.child_count = shape & 0xF;
  if (node.child_count > kMaxWidth || (mixed && leaf == 0) || (irregular && (shape & 0x70) != 0)) {
    shapes.fail("holds an impossible node shape");
  }
  unsigned kinds = leaf * 0x5555;
  if (mixed) {
    const unsigned internal = readers_[Column::node_kinds].u8();
    kinds &= ~(spread_bits(internal) * 3);
  } else if (irregular) {
    kinds = readers_[Column::node_kinds].u8();
    kinds |= static_cast<unsigned>(readers_[Column::node_kinds].u8()) << 8;
  }
  for (unsigned slot = 0; slot < node.child_count; ++slot) {
    node.child_kinds[slot] = kStoredKinds[kinds >> (2 * slot) & 3];
  }
}

}  // namespace grtx::traces
