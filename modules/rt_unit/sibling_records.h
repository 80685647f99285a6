// Which siblings a leaf brings along: what each lane remembers of its internal visits. Without time: the sibling
// prefetcher, fast mode and functional warming ask here.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/rt_unit/node_traffic.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

/// Hit children of a node that nobody has asked for.
struct Siblings {
  std::uint32_t definition = 0;  ///< of the node, in RayGroup::nodes
  unsigned mask = 0;             ///< slots; 0: none
};

class SiblingRecords {
 public:
  static constexpr unsigned kMaxRecords = 8;

  /// records: internal visits remembered a lane, 1..kMaxRecords; a new one replaces the oldest.
  SiblingRecords(std::size_t lanes, unsigned records, const NodeTraffic& traffic);

  /// A lane begins a round: what it remembers is void.
  void begin(std::size_t lane);
  /// The lane's visit of group.nodes[definition] found the children in `hit`: they are remembered if there are two and
  /// one of them is a leaf, which can ask for the others.
  void note(std::size_t lane, const traces::RayGroup& group, std::uint32_t definition, unsigned hit);
  /// The lane asks for the leaf at `address` (in units). The first of a node's hit children that is asked for brings
  /// the others.
  Siblings take(std::size_t lane, const traces::RayGroup& group, std::uint32_t address);
  /// f(kind, address in units) for the children in the slots of `mask`, in slot order.
  template <typename F>
  void for_each_child(const traces::NodeDefinition& node, unsigned mask, F&& f) const {
    std::uint32_t child = node.child_base;  // children are contiguous in slot order
    for (unsigned i = 0; i < node.child_count; ++i) {
      const traces::NodeKind kind = node.child_kinds[i];
      if ((mask >> i & 1) != 0) f(kind, child);
      child += units_[static_cast<std::size_t>(kind)];
    }
  }
  std::size_t size() const { return records_.size(); }  ///< of all lanes

 private:
  struct Record {
    std::uint32_t begin = 0, end = 0;  ///< addresses of the children in units
    std::uint32_t definition = 0;
    std::uint8_t hit = 0;
    bool armed = false;
  };
  /// Slot of the child at `address`; kMaxWidth: there is none.
  unsigned slot_of(const traces::NodeDefinition& node, std::uint32_t address) const;

  unsigned a_lane_;
  std::array<std::uint32_t, 8> units_{};  ///< units that a node takes in the image, by kind
  std::vector<Record> records_;           ///< a_lane_ of each lane
  std::vector<std::uint8_t> newest_;      ///< of a lane's records
};

/// What the lanes of one warp have asked for in one cycle: a node's siblings are brought once.
class SiblingRequests {
 public:
  void begin() { count_ = 0; }
  /// The slots of `siblings` that no lane has asked for before.
  unsigned fresh(const Siblings& siblings) {
    unsigned i = 0;
    while (i < count_ && asked_[i].definition != siblings.definition) ++i;
    if (i == count_) asked_[count_++] = {siblings.definition, 0};
    const unsigned fresh = siblings.mask & ~asked_[i].mask;
    asked_[i].mask |= siblings.mask;
    return fresh;
  }

 private:
  std::array<Siblings, kMaxLanes> asked_{};
  unsigned count_ = 0;
};

}  // namespace grtx::modules
