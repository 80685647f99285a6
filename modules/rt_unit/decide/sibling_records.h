// Which siblings a leaf brings along: what each lane remembers of its internal visits. The sibling
// prefetcher asks here, with and without time.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

/// Hit children of a node that nobody has asked for.
struct Siblings {
  std::uint32_t definition = 0;  ///< of the node, in RayGroup::nodes
  unsigned mask = 0;             ///< slots; 0: none
  bool replayed = false;         ///< a source entry named them
};

class SiblingRecords {
 public:
  static constexpr unsigned kMaxRecords = 8;

  /// records: internal visits remembered a lane, 1..kMaxRecords; a new one replaces the oldest. replayed: checkpoint
  /// entries name the siblings with which they were written, and a leaf that is replayed asks for them.
  SiblingRecords(std::size_t lanes, unsigned records, bool replayed, const NodeTraffic& traffic);

  /// A lane begins a round of ray number `ray`: what it remembers is void; what its source entries name is not, if it
  /// replays them.
  void begin(std::size_t lane, std::size_t ray, bool replays);
  /// The lane's visit of group.nodes[definition] found the children in `hit`: they are remembered if there are two and
  /// one of them is a leaf, which can ask for the others. It wrote the children in `checkpointed` to checkpoint
  /// entries.
  void note(std::size_t lane, const traces::RayGroup& group, std::uint32_t definition, unsigned hit,
            unsigned checkpointed);
  /// The lane's next node is one that a source entry names, at `address` (in units).
  void note_replayed(std::size_t lane, std::uint32_t address) { replayed_of_[lane] = address; }
  /// The lane asks for the leaf at `address` (in units). The first of a node's hit children that is asked for brings
  /// the others; so does the first in a round of those that were checkpointed together.
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
  /// What the entries of a visit's children say: they are in memory with the entries, and not the prefetcher's.
  struct Checkpointed {
    std::uint32_t begin = 0, end = 0;
    std::uint32_t definition = 0;
    std::uint8_t mask = 0;
  };
  void remember(std::size_t lane, const Record& record);
  Siblings take_replayed(std::size_t lane, const traces::RayGroup& group, std::uint32_t address);
  /// Slot of the child at `address`; kMaxWidth: there is none.
  unsigned slot_of(const traces::NodeDefinition& node, std::uint32_t address) const;

  unsigned a_lane_;
  std::array<std::uint32_t, 8> units_{};  ///< units that a node takes in the image, by kind
  std::vector<Record> records_;           ///< a_lane_ of each lane
  std::vector<std::uint8_t> newest_;      ///< of a lane's records
  bool replayed_;
  std::uint32_t shared_from_;                            ///< nodes of the shared BLAS begin here
  std::vector<std::uint32_t> replayed_of_;               ///< by lane: address of the node taken last
  std::vector<std::size_t> ray_of_;                      ///< by lane
  std::vector<std::vector<Checkpointed>> checkpointed_;  ///< by ray, in the order of visits
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
