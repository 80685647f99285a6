// SPDX-License-Identifier: Apache-2.0
// Which siblings to prefetch with a leaf: each lane's records of its recent internal visits. Used by the timed and the
// functional path of the sibling prefetcher.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/modules/rt_unit/prefetcher/decide/prefetcher_config.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

/// Hit children of a node to prefetch.
struct Siblings {
  std::uint32_t definition = 0;  ///< index of the node in RayGroup::nodes
  unsigned mask = 0;             ///< child slots; 0: none
  bool replayed = false;         ///< triggered by a source entry
};

class SiblingRecords {
 public:
  static constexpr unsigned kMaxRecords = PrefetcherConfig::kMaxRecords;

  /// records: internal visits remembered per lane, 1..kMaxRecords; a new one replaces the oldest. replayed: checkpoint
  /// entries name the siblings written with them, and a replayed leaf prefetches these. Throws Error for wrong records.
  SiblingRecords(std::size_t lanes, unsigned records, bool replayed, const NodeTraffic& traffic);

  /// A lane begins a round of ray number `ray`: clears its records; siblings named by checkpoint entries stay in a
  /// replay.
  void begin(std::size_t lane, std::size_t ray, bool replays);
  /// The lane visited group.nodes[definition]: it hit the children in `hit` and checkpointed those in `checkpointed`.
  /// Each set is recorded if it has at least two children, one of them a leaf, which can trigger a prefetch.
  void note(std::size_t lane, const traces::RayGroup& group, std::uint32_t definition, unsigned hit,
            unsigned checkpointed);
  /// The lane's next node, at `address` (in units), comes from a source entry.
  void note_replayed(std::size_t lane, std::uint32_t address) { replayed_of_[lane] = address; }
  /// The lane visits the leaf at `address` (in units). The first visited leaf among a node's hit children returns the
  /// others; so does the first one in a round among children that were checkpointed together.
  Siblings take(std::size_t lane, const traces::RayGroup& group, std::uint32_t address);
  /// Calls f(kind, address in units) for the children in the slots of `mask`, in slot order.
  template <typename F>
  void for_each_child(const traces::NodeDefinition& node, unsigned mask, F&& f) const {
    std::uint32_t child = node.child_base;  // children are contiguous in slot order
    for (unsigned i = 0; i < node.child_count; ++i) {
      const traces::NodeKind kind = node.child_kinds[i];
      if ((mask >> i & 1) != 0) f(kind, child);
      child += units_[static_cast<std::size_t>(kind)];
    }
  }
  std::size_t size() const { return records_.size(); }  ///< records of all lanes

 private:
  struct Record {
    std::uint32_t begin = 0, end = 0;  ///< address range of the children, in units
    std::uint32_t definition = 0;
    std::uint8_t hit = 0;
    bool armed = false;
  };
  /// Siblings named in the checkpoint entries of one visit: part of the entries in memory, no storage of the
  /// prefetcher.
  struct Checkpointed {
    std::uint32_t begin = 0, end = 0;
    std::uint32_t definition = 0;
    std::uint8_t mask = 0;
  };
  void remember(std::size_t lane, const Record& record);
  Siblings take_replayed(std::size_t lane, const traces::RayGroup& group, std::uint32_t address);
  /// Slot of the child at `address`; kMaxWidth if there is none.
  unsigned slot_of(const traces::NodeDefinition& node, std::uint32_t address) const;

  unsigned a_lane_;
  std::array<std::uint32_t, 8> units_{};  ///< [NodeKind] node size in the image, in units
  std::vector<Record> records_;           ///< [lane * a_lane_ + record]
  std::vector<std::uint8_t> newest_;      ///< [lane] index of its newest record
  bool replayed_;
  std::uint32_t shared_from_;                            ///< first address of the shared BLAS, in units
  std::vector<std::uint32_t> replayed_of_;               ///< [lane] address of the node last replayed
  std::vector<std::size_t> ray_of_;                      ///< [lane]
  std::vector<std::vector<Checkpointed>> checkpointed_;  ///< [ray] in visit order
};

/// Prefetches triggered by the lanes of one warp in one cycle, so that a node's siblings are requested once.
class SiblingRequests {
 public:
  void begin() { count_ = 0; }
  /// The slots of `siblings` that no lane has requested since begin().
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
