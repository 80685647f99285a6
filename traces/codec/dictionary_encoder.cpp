// SPDX-License-Identifier: Apache-2.0
#include "grtx/traces/codec/dictionary_encoder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <stdexcept>
#include <utility>

#include "grtx/traces/codec/group_codec.h"
#include "grtx/traces/codec/node_shape.h"

namespace grtx::traces {

void DictionaryEncoder::begin(const NodeSource& source) {
  source_ = &source;
  records_.clear();
  all_listed_ = false;
}

void DictionaryEncoder::list(const std::vector<NodeDefinition>& nodes) {
  std::int64_t last_address = -1;
  for (const NodeDefinition& node : nodes) {
    place_.require(node.address > last_address, "nodes must ascend by address");
    last_address = node.address;
    add(node);
  }
  all_listed_ = true;
}

std::uint32_t DictionaryEncoder::add(const NodeDefinition& definition) {
  const NodeShape& shape = model_.shape(definition);
  NodeRecord record;
  record.address = definition.address;
  record.kinds_code = shape.kinds_code;
  record.code = shape.code;
  record.units = shape.units;
  records_.push_back(record);
  try {
    return model_.add(definition, shape);
  } catch (const std::invalid_argument& fault) {
    place_.fail(fault.what());
  }
}

std::uint32_t DictionaryEncoder::reach(std::uint32_t parent, unsigned slot, std::uint32_t address) {
  std::uint32_t index = 0;
  if (all_listed_) {
    const auto end = records_.end();
    const auto found = std::lower_bound(records_.begin(), end, address,
                                        [](const NodeRecord& r, std::uint32_t a) { return r.address < a; });
    place_.require(found != end && found->address == address, "the visited node is missing in the dictionary");
    index = model_.first_node() + static_cast<std::uint32_t>(found - records_.begin());
  } else {
    index = add(source_->define(address));
  }
  model_[parent].links[slot] = index;
  return index;
}

void DictionaryEncoder::visit_first(std::uint32_t index, unsigned hits) {
  NodeRecord& record = records_[index - model_.first_node()];
  if (record.visited) return;
  record.visited = true;
  record.first_hits = static_cast<std::uint8_t>(hits);
  model_[index].last_hits = static_cast<std::uint8_t>(hits);
}

unsigned DictionaryEncoder::put(ColumnWriter& columns) {
  unsigned flags = 0;
  if (put_tree(columns, flags)) return flags;
  put_by_address(columns);
  return 0;
}

// Pushes the visited children from the last to the first, so that the first is on top; addresses must ascend. A child
// that no ray visited sets kSkipped on the entry then on top.
[[gnu::always_inline]] inline DictionaryEncoder::Children DictionaryEncoder::push_children(const NodeModel& node,
                                                                                           std::size_t& depth) {
  const NodeRecord* const records = records_.data();
  const NodeModel* const nodes = model_.nodes();
  std::uint32_t* const walk = walk_.data();
  Children children;
  for (unsigned left = node.internal_mask; left != 0;) {
    const unsigned slot = static_cast<unsigned>(std::bit_width(left)) - 1;
    left ^= 1U << slot;
    const std::uint32_t child = node.links[slot];
    if (child == NodeModel::kUnknownLink) {
      if (depth != 0) walk[depth - 1] |= kSkipped;
      continue;
    }
    if (children.mask == 0) children.last = child;
    children.first = child;
    children.mask |= 1U << slot;
    walk[depth++] = child;
    __builtin_prefetch(&nodes[child]);
    __builtin_prefetch(&records[child - model_.first_node()]);
  }
  return children;
}

// Builders usually place nodes depth first, a node's children before their subtrees. Then addresses follow from the
// tree: each group of children directly follows the previous one, except for a gap where unvisited subtrees lie
// between. Returns false if the addresses do not have this order, and then leaves the columns unchanged.
bool DictionaryEncoder::put_tree(ColumnWriter& columns, unsigned& flags) {
  static constexpr Column kColumns[] = {Column::node_tree, Column::node_shape, Column::node_kinds,
                                        Column::node_children, Column::node_hits};
  std::array<std::uint8_t*, 5> ends{};
  for (std::size_t i = 0; i < ends.size(); ++i) {
    columns.reserve(kColumns[i], 5 * records_.size());
    ends[i] = columns.end(kColumns[i]);
  }
  auto [tree, shapes, kinds, children, hits] = ends;
  const NodeRecord* const records = records_.data();
  const NodeModel* const nodes = model_.nodes();
  walk_.resize(records_.size() + kMaxWidth);
  std::uint32_t* const walk = walk_.data();
  std::size_t found = 0;
  std::int64_t last_address = -1;  // highest address of the nodes found so far
  std::uint64_t end = 0;           // end of the children so far, units
  flags = kNodesInTree;
  for (const auto& [parent, flag] : {std::pair{GroupModel::kRootParent, kNodesHoldRoot},
                                     std::pair{GroupModel::kBlasRootParent, kNodesHoldBlasRoot}}) {
    const std::uint32_t root = nodes[parent].links[0];
    if (root == NodeModel::kUnknownLink) continue;
    flags |= flag;
    const std::int64_t root_address = records[root - model_.first_node()].address;
    if (root_address <= last_address || found == records_.size()) return false;
    last_address = root_address;
    ++found;
    walk[0] = root | kSkipped;
    std::size_t depth = 1;
    while (depth != 0) {
      const std::uint32_t entry = walk[--depth];
      const bool skipped = (entry & kSkipped) != 0;
      const std::uint32_t index = entry & ~kSkipped;
      const NodeModel& node = nodes[index];
      const NodeRecord& record = records[index - model_.first_node()];
      if (node.child_base < end || (!skipped && node.child_base > end)) return false;
      if (skipped) children = store_varint(children, node.child_base - end);
      end = node.child_base + record.units;
      *shapes++ = record.code;
      kinds = store_kinds(kinds, record);
      const Children below = push_children(node, depth);
      found += static_cast<std::size_t>(std::popcount(below.mask));
      if (found > records_.size()) return false;
      if (below.mask != 0) {
        if (records[below.first - model_.first_node()].address <= last_address) return false;
        last_address = records[below.last - model_.first_node()].address;
      }
      *tree = static_cast<std::uint8_t>(below.mask);
      tree += node.internal_mask != 0 ? 1 : 0;
      *hits++ = static_cast<std::uint8_t>((record.visited ? record.first_hits : 0) ^ below.mask);
    }
  }
  if (found != records_.size()) return false;
  ends = {tree, shapes, kinds, children, hits};
  for (std::size_t i = 0; i < ends.size(); ++i) columns.end(kColumns[i]) = ends[i];
  return true;
}

void DictionaryEncoder::put_by_address(ColumnWriter& columns) {
  const std::size_t count = records_.size();
  columns.reserve(Column::node_address, 5 * count);
  columns.reserve(Column::node_children, 10 * count);
  walk_.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) walk_[i] = i;
  std::sort(walk_.begin(), walk_.end(),
            [&](std::uint32_t a, std::uint32_t b) { return records_[a].address < records_[b].address; });
  std::int64_t last_address = -1;
  std::int64_t predicted_children = 0;
  for (const std::uint32_t i : walk_) {
    const NodeRecord& record = records_[i];
    const std::uint32_t child_base = model_[model_.first_node() + i].child_base;
    place_.require(record.address > last_address, "two parents lead to one node");
    columns.put_varint(Column::node_address,
                       static_cast<std::uint64_t>(record.address - std::max<std::int64_t>(last_address, 0)));
    last_address = record.address;
    columns.put_varint(Column::node_children, zigzag(static_cast<std::int64_t>(child_base) - predicted_children));
    predicted_children = static_cast<std::int64_t>(child_base) + record.units;
    columns.put(Column::node_shape, record.code);
    columns.end(Column::node_kinds) = store_kinds(columns.end(Column::node_kinds), record);
    columns.put(Column::node_hits, record.first_hits);
  }
}

// Writes the record's bytes for column node_kinds and returns their end.
std::uint8_t* DictionaryEncoder::store_kinds(std::uint8_t* at, const NodeRecord& record) {
  if ((record.code & (kShapeMixed | kShapeIrregular)) == 0) return at;
  *at++ = static_cast<std::uint8_t>(record.kinds_code);
  if ((record.code & kShapeIrregular) != 0) *at++ = static_cast<std::uint8_t>(record.kinds_code >> 8);
  const unsigned wide = kShapeIrregular | kShapeWide;
  if ((record.code & wide) == wide) *at++ = static_cast<std::uint8_t>(record.kinds_code >> 16);
  return at;
}

}  // namespace grtx::traces
