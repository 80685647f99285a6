// The dictionary of a group being encoded: the internal nodes that its rays visited, stored as a tree where their
// addresses allow that.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "grtx/traces/codec/columns.h"
#include "grtx/traces/codec/group_model.h"
#include "grtx/traces/codec/group_place.h"
#include "grtx/traces/codec/node_source.h"
#include "grtx/traces/event.h"

namespace grtx::traces {

/// Keeps its memory. Errors are std::logic_error, at `place`.
class DictionaryEncoder {
 public:
  /// Nodes are added to `model`, which its owner begins. Both references must outlive this.
  DictionaryEncoder(GroupModel& model, const GroupPlace& place) : model_(model), place_(place) {}

  /// Forgets all nodes. `source` must live until the last reach().
  void begin(const NodeSource& source);
  /// All nodes, ascending by address: none is asked of the source.
  void list(const std::vector<NodeDefinition>& nodes);
  /// Index into the model of the node at `address` (in units) that a visit reaches for the first time through this
  /// slot of this parent. References to nodes of the model become invalid.
  std::uint32_t reach(std::uint32_t parent, unsigned slot, std::uint32_t address);
  /// What that visit hit, unless the node had been visited before.
  void visit_first(std::uint32_t index, unsigned hits);
  std::size_t size() const { return records_.size(); }
  /// Fills the columns of nodes. Returns how they are stored (kNodesInTree and others).
  unsigned put(ColumnWriter& columns);

 private:
  /// With an index: a child that no ray visited lies before it.
  static constexpr std::uint32_t kSkipped = 1U << 31;

  /// What the dictionary stores of a node beside its model.
  struct NodeRecord {
    std::uint32_t address = 0;
    std::uint16_t kinds_code = 0;
    std::uint8_t code = 0;
    std::uint8_t units = 0;
    std::uint8_t first_hits = 0;
    bool visited = false;
  };

  std::uint32_t add(const NodeDefinition& definition);
  /// Children of a node that rays visited.
  struct Children {
    unsigned mask = 0;
    std::uint32_t first = 0, last = 0;  ///< indices; of none in an empty mask
  };
  /// Puts them on top of the walk's stack, which has room for all that a node can have.
  Children push_children(const NodeModel& node, std::size_t& depth);
  bool put_tree(ColumnWriter& columns, unsigned& flags);
  void put_by_address(ColumnWriter& columns);
  static std::uint8_t* store_kinds(std::uint8_t* at, const NodeRecord& record);

  GroupModel& model_;
  const GroupPlace& place_;
  const NodeSource* source_ = nullptr;
  std::vector<NodeRecord> records_;  ///< of the model's nodes from model_.first_node() on
  bool all_listed_ = false;          ///< list() made the records, by ascending address
  std::vector<std::uint32_t> walk_;
};

}  // namespace grtx::traces
