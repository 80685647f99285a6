#include "traces/dictionary_encoder.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <stdexcept>
#include <utility>

#include "traces/group_codec.h"
#include "traces/group_encoder.h"
#include "traces/node_shape.h"

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

std::uint32_t DictionaryEncoder::reach(std::uint32_t parent, unsigned slot, std::uint32_t address, unsigned hits) {
  std::uint32_t index = 0;
  if (all_listed_) {
    const auto end = records_.end();
    const auto found = std::lower_bound(records_.begin(), end, address,
                                        [](const NodeRecord& r, std::uint32_t a) { return r.address < a; });
    place_.require(found != end && found->address == address, "the visited node is missing in the dictionary");
    index = GroupModel::kFirstNode + static_cast<std::uint32_t>(found - records_.begin());
  } else {
    index = add(source_->define(address));
  }
  model_[parent].links[slot] = index;
  NodeRecord& record = records_[index - GroupModel::kFirstNode];
  if (!record.visited) {
    record.visited = true;
    record.first_hits = static_cast<std::uint8_t>(hits);
    model_[index].last_hits = static_cast<std::uint8_t>(hits);
  }
  return index;
}

unsigned DictionaryEncoder::put(ColumnWriter& columns) {
  unsigned flags = 0;
  if (put_tree(columns, flags)) return flags;
  put_by_address(columns);
  return 0;
}

// Depth first, a node's children before their subtrees, is the order of addresses where builders pack trees so.
// Addresses then follow from the tree, and children lie behind all that came before: right behind unless subtrees lie
// between that no ray visited. Returns false otherwise.
bool DictionaryEncoder::put_tree(ColumnWriter& columns, unsigned& flags) {
  const Column node_columns[] = {Column::node_tree, Column::node_shape, Column::node_kinds, Column::node_children,
                                 Column::node_hits};
  for (const Column column : node_columns) columns.reserve(column, 5 * records_.size());
  const auto record_of = [&](std::uint32_t index) -> NodeRecord& { return records_[index - GroupModel::kFirstNode]; };
  std::size_t found = 0;
  std::int64_t last_address = -1;  // of the nodes found so far, in their order
  std::uint64_t end = 0;           // of the children so far
  const auto is_next = [&](std::uint32_t index) {
    const std::int64_t address = record_of(index).address;
    ++found;
    return address > std::exchange(last_address, address);
  };
  const auto walk = [&](std::uint32_t root) {
    if (!is_next(root)) return false;
    bool skipped = true;
    walk_.assign(1, root);
    while (!walk_.empty()) {
      const std::uint32_t index = walk_.back();
      walk_.pop_back();
      if (index == kSkipped) {
        skipped = true;
        continue;
      }
      const NodeModel& node = model_[index];
      const NodeRecord& record = record_of(index);
      if (node.child_base < end || (!skipped && node.child_base > end)) return false;
      if (skipped) columns.put_varint(Column::node_children, node.child_base - end);
      skipped = false;
      end = node.child_base + record.units;
      put_shape(columns, record);
      unsigned mask = 0;
      const std::size_t first = walk_.size();
      for (unsigned left = node.internal_mask; left != 0; left &= left - 1) {
        const auto slot = static_cast<unsigned>(std::countr_zero(left));
        const std::uint32_t child = node.links[slot];
        const bool known = child != NodeModel::kUnknownLink;
        if (known && (found == records_.size() || !is_next(child))) return false;
        mask |= (known ? 1U : 0U) << slot;
        walk_.push_back(known ? child : kSkipped);
      }
      std::reverse(walk_.begin() + static_cast<std::ptrdiff_t>(first), walk_.end());
      if (node.internal_mask != 0) columns.put(Column::node_tree, mask);
      columns.put(Column::node_hits, (record.visited ? record.first_hits : 0) ^ mask);
    }
    return true;
  };
  flags = kNodesInTree;
  bool tree = true;
  for (const auto& [parent, flag] : {std::pair{GroupModel::kRootParent, kNodesHoldRoot},
                                     std::pair{GroupModel::kBlasRootParent, kNodesHoldBlasRoot}}) {
    const std::uint32_t root = model_[parent].links[0];
    if (root == NodeModel::kUnknownLink || !tree) continue;
    flags |= flag;
    tree = walk(root);
  }
  if (tree && found == records_.size()) return true;
  for (const Column column : node_columns) columns.clear(column);
  return false;
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
    const std::uint32_t child_base = model_[GroupModel::kFirstNode + i].child_base;
    place_.require(record.address > last_address, "two parents lead to one node");
    columns.put_varint(Column::node_address,
                       static_cast<std::uint64_t>(record.address - std::max<std::int64_t>(last_address, 0)));
    last_address = record.address;
    columns.put_varint(Column::node_children, zigzag(static_cast<std::int64_t>(child_base) - predicted_children));
    predicted_children = static_cast<std::int64_t>(child_base) + record.units;
    put_shape(columns, record);
    columns.put(Column::node_hits, record.first_hits);
  }
}

void DictionaryEncoder::put_shape(ColumnWriter& columns, const NodeRecord& record) {
  columns.put(Column::node_shape, record.code);
  if ((record.code & (kShapeMixed | kShapeIrregular)) == 0) return;
  columns.put(Column::node_kinds, record.kinds_code & 0xFF);
  if ((record.code & kShapeIrregular) != 0) columns.put(Column::node_kinds, record.kinds_code >> 8);
}

}  // namespace grtx::traces
