// The dictionary of a group being decoded: undoes DictionaryEncoder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "grtx/traces/codec/columns.h"
#include "grtx/traces/codec/group_model.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::traces {

/// Keeps its memory. Throws Malformed.
class DictionaryDecoder {
 public:
  /// Reads from `readers` and adds nodes to `model`, which GroupDecoder begins. Both must outlive this.
  DictionaryDecoder(ColumnReaders& readers, GroupModel& model) : readers_(readers), model_(model) {}

  /// Fills `nodes`, whose size is their number, ascending by address: node i is model_.first_node() + i of the
  /// model. `flags` tell how they are stored (kNodesInTree and others).
  void take(const Header& header, unsigned flags, std::vector<NodeDefinition>& nodes);

 private:
  void take_by_address(std::vector<NodeDefinition>& nodes);
  void take_tree(const Header& header, unsigned flags, std::vector<NodeDefinition>& nodes);
  const NodeShape& take_shape(NodeDefinition& node);
  void set(std::uint32_t index, const NodeDefinition& node, const NodeShape& shape, unsigned tree_mask);
  void ascend(std::int64_t address);

  ColumnReaders& readers_;
  GroupModel& model_;
  std::int64_t last_address_ = -1;
  std::vector<std::uint32_t> walk_;
};

}  // namespace grtx::traces
