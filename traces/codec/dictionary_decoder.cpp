// SPDX-License-Identifier: Apache-2.0
#include "grtx/traces/codec/dictionary_decoder.h"

#include <bit>
#include <limits>
#include <stdexcept>

#include "grtx/traces/codec/group_codec.h"
#include "grtx/traces/codec/node_shape.h"

namespace grtx::traces {
namespace {

constexpr std::uint64_t kMaxU32 = std::numeric_limits<std::uint32_t>::max();

constexpr std::uint32_t kSkipped = 1U << 31;  ///< flag in a node index: an unvisited child comes before it

}  // namespace

void DictionaryDecoder::take(const Header& header, unsigned flags, std::vector<NodeDefinition>& nodes) {
  last_address_ = -1;
  model_.add_unset(nodes.size());
  try {
    if (flags == 0) {
      take_by_address(nodes);
    } else {
      take_tree(header, flags, nodes);
    }
  } catch (const std::invalid_argument& fault) {
    throw Malformed(fault.what());
  }
}

// Checks that addresses ascend, so that model and dictionary have the same order.
void DictionaryDecoder::ascend(std::int64_t address) {
  if (address <= last_address_) throw Malformed("nodes must ascend by address");
  last_address_ = address;
}

/// tree_mask: the node's children in the tree; 0 if the dictionary is not stored as a tree.
void DictionaryDecoder::set(std::uint32_t index, const NodeDefinition& node, const NodeShape& shape,
                            unsigned tree_mask) {
  model_.set(model_.first_node() + index, node, shape);
  NodeModel& model = model_[model_.first_node() + index];
  ByteReader& hits = readers_[Column::node_hits];
  model.last_hits = static_cast<std::uint8_t>(hits.u8() ^ tree_mask);
  if (model.last_hits >> model.child_count != 0) hits.fail("names a child that is not there");
}

void DictionaryDecoder::take_by_address(std::vector<NodeDefinition>& nodes) {
  std::uint32_t address = 0;
  std::int64_t predicted_children = 0;
  ByteReader& addresses = readers_[Column::node_address];
  ByteReader& children = readers_[Column::node_children];
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    NodeDefinition& node = nodes[i];
    address = checked_u32(addresses, address + static_cast<std::int64_t>(addresses.varint(kMaxU32)));
    node.address = address;
    ascend(address);
    node.child_base = checked_u32(children, predicted_children + unzigzag(children.varint(4 * kMaxU32)));
    const NodeShape& shape = take_shape(node);
    predicted_children = std::int64_t{node.child_base + shape.units};
    set(i, node, shape, 0);
  }
}

void DictionaryDecoder::take_tree(const Header& header, unsigned flags, std::vector<NodeDefinition>& nodes) {
  ByteReader& children = readers_[Column::node_children];
  ByteReader& masks = readers_[Column::node_tree];
  std::uint32_t next = 0;
  std::int64_t end = 0;
  walk_.resize(nodes.size());
  for (const unsigned root : {kNodesHoldRoot, kNodesHoldBlasRoot}) {
    if ((flags & root) == 0) continue;
    const bool first = root == kNodesHoldRoot;
    if (next == nodes.size()) masks.fail("names more nodes than there are");
    const auto at = static_cast<std::int64_t>((first ? header.root : header.blas_root) / header.node_sizes().unit());
    nodes[next].address = checked_u32(masks, at);
    ascend(at);
    model_[first ? GroupModel::kRootParent : GroupModel::kBlasRootParent].links[0] = model_.first_node() + next;
    walk_[0] = next++ | kSkipped;
    std::size_t depth = 1;
    while (depth != 0) {
      const std::uint32_t entry = walk_[--depth];
      const std::uint32_t index = entry & ~kSkipped;
      NodeDefinition& node = nodes[index];
      const std::int64_t gap = (entry & kSkipped) != 0 ? static_cast<std::int64_t>(children.varint(kMaxU32)) : 0;
      node.child_base = checked_u32(children, end + gap);
      const NodeShape& shape = take_shape(node);
      const unsigned linked = shape.internal_mask != 0 ? masks.u8() : 0;
      if ((linked & ~unsigned{shape.internal_mask}) != 0) masks.fail("names a child that is not internal");
      set(index, node, shape, linked);
      end = static_cast<std::int64_t>(node.child_base) + shape.units;
      const unsigned count = bits_of_byte(linked);
      if (count > nodes.size() - next) masks.fail("names more nodes than there are");
      // The lowest slot is walked first, so it goes on top.
      unsigned skipped = shape.internal_mask & ~linked;
      if (depth != 0 && skipped > linked) walk_[depth - 1] |= kSkipped;
      NodeModel& model = model_[model_.first_node() + index];
      depth += count;
      std::size_t place = depth;
      for (unsigned left = linked; left != 0; left &= left - 1) {
        const auto slot = static_cast<unsigned>(std::countr_zero(left));
        const std::int64_t address = static_cast<std::int64_t>(node.child_base) + (shape.offsets >> (4 * slot) & 0xF);
        nodes[next].address = checked_u32(masks, address);
        ascend(address);
        model.links[slot] = model_.first_node() + next;
        const unsigned before = (1U << slot) - 1;
        walk_[--place] = next++ | ((skipped & before) != 0 ? kSkipped : 0);
        skipped &= ~before;
      }
    }
  }
  if (next != nodes.size()) masks.fail("names fewer nodes than there are");
}

const NodeShape& DictionaryDecoder::take_shape(NodeDefinition& node) {
  ByteReader& shapes = readers_[Column::node_shape];
  ByteReader& kinds = readers_[Column::node_kinds];
  const unsigned code = shapes.u8();
  unsigned kinds_code = 0;
  if ((code & kShapeMixed) != 0) {
    kinds_code = kinds.u8();
  } else if ((code & kShapeIrregular) != 0) {
    kinds_code = kinds.u8();
    kinds_code |= static_cast<unsigned>(kinds.u8()) << 8;
    if ((code & kShapeWide) != 0) kinds_code |= static_cast<unsigned>(kinds.u8()) << 16;
  }
  const ShapeTable::Stored* const stored = model_.shapes().stored(code, kinds_code);
  if (stored == nullptr) shapes.fail("holds an impossible node shape");
  node.child_count = code & 0xF;
  node.child_kinds = stored->kinds;
  return stored->shape;
}

}  // namespace grtx::traces
