// SPDX-License-Identifier: Apache-2.0
// Encodes the node dictionary of a group: the internal nodes that its rays visited, stored as a tree if their addresses
// allow it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "grtx/traces/codec/columns.h"
#include "grtx/traces/codec/group_model.h"
#include "grtx/traces/codec/group_place.h"
#include "grtx/traces/event.h"
#include "grtx/traces/node_source.h"

namespace grtx::traces {

/// Reuses its memory for the next group. Throws std::logic_error that names `place`.
class DictionaryEncoder {
 public:
  /// Adds nodes to `model`, whose begin() is called by its owner. Both references must outlive this.
  DictionaryEncoder(GroupModel& model, const GroupPlace& place) : model_(model), place_(place) {}

  /// Starts a new group without nodes. `source` must stay valid until the last reach().
  void begin(const NodeSource& source);
  /// Sets all nodes, ascending by address; the source is then not used.
  void list(const std::vector<NodeDefinition>& nodes);
  /// A visit reaches the node at `address` (in units) for the first time through this slot of this parent. Returns its
  /// index in the model. Invalidates references to nodes of the model.
  std::uint32_t reach(std::uint32_t parent, unsigned slot, std::uint32_t address);
  /// Records the hits of the node's first visit; ignored for later visits.
  void visit_first(std::uint32_t index, unsigned hits);
  std::size_t size() const { return records_.size(); }
  /// Fills the node columns. Returns how the nodes are stored (kNodesInTree and others).
  unsigned put(ColumnWriter& columns);

 private:
  /// Flag in a node index: an unvisited child comes before this node.
  static constexpr std::uint32_t kSkipped = 1U << 31;

  /// Data of a dictionary node in addition to its NodeModel.
  struct NodeRecord {
    std::uint32_t address = 0;
    std::uint32_t kinds_code = 0;
    std::uint8_t code = 0;
    std::uint8_t units = 0;
    std::uint8_t first_hits = 0;
    bool visited = false;
  };

  std::uint32_t add(const NodeDefinition& definition);
  /// The visited internal children of a node.
  struct Children {
    unsigned mask = 0;
    std::uint32_t first = 0, last = 0;  ///< model indices; undefined if mask is 0
  };
  /// Pushes the visited children of a node on the stack walk_ of size `depth`; there must be room for kMaxWidth.
  Children push_children(const NodeModel& node, std::size_t& depth);
  bool put_tree(ColumnWriter& columns, unsigned& flags);
  void put_by_address(ColumnWriter& columns);
  static std::uint8_t* store_kinds(std::uint8_t* at, const NodeRecord& record);

  GroupModel& model_;
  const GroupPlace& place_;
  const NodeSource* source_ = nullptr;
  std::vector<NodeRecord> records_;  ///< [model index - model_.first_node()]
  bool all_listed_ = false;          ///< the records come from list() and ascend by address
  std::vector<std::uint32_t> walk_;
};

}  // namespace grtx::traces
