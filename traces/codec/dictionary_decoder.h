// SPDX-License-Identifier: Apache-2.0
// Decodes the node dictionary of a group; inverse of DictionaryEncoder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "grtx/traces/codec/columns.h"
#include "grtx/traces/codec/group_model.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::traces {

/// Reuses its memory for the next group. Throws Malformed.
class DictionaryDecoder {
 public:
  /// Reads from `readers` and adds nodes to `model`, whose begin() is called by GroupDecoder. Both must outlive this.
  DictionaryDecoder(ColumnReaders& readers, GroupModel& model) : readers_(readers), model_(model) {}

  /// Fills `nodes`, already of the right size, ascending by address; node i has index model_.first_node() + i in the
  /// model. flags: how they are stored (kNodesInTree and others).
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
