// SPDX-License-Identifier: Apache-2.0
// What merges: whether the read of a node joins a fetch that its warp has under way. Lanes of different warps never
// share a fetch.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/modules/kernel/address_index.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/rt_unit/decide/node_visit.h"
#include "grtx/traces/node_layout.h"

namespace grtx::modules {

class FetchMerge {
 public:
  static constexpr std::uint32_t kNone = AddressIndex::kNone;

  /// in_flight: reads join each fetch of their warp until its data come; otherwise only those that the warp began since
  /// it was last selected.
  FetchMerge(unsigned entries, bool in_flight) : in_flight_(in_flight), fetches_(entries, AddressIndex(kMaxLanes)) {}

  /// Reads of one warp merge if their keys are equal. Visits of an instance leaf with and without a header differ, a
  /// leaf differs from its descriptor, and a header that is fetched alone is no node.
  static std::uint64_t key(const NodeVisit& visit, NodePart part, const NodeTraffic& traffic) {
    if (part == NodePart::second) return number(NodeSectors(visit, traffic, part).address(), true);
    return number(visit.address, visit.header);
  }

  /// The warp in `entry` is selected: its visits follow.
  void begin_warp(unsigned entry) {
    if (in_flight_) return;
    for (const std::uint64_t key : begun_) fetches_[entry_].erase(key);
    begun_.clear();
    entry_ = entry;
  }
  /// First lane of the fetch that serves this read of the warp, too; kNone if the read needs a fetch of its own.
  std::uint32_t find(unsigned entry, std::uint64_t key, NodePart part) const {
    return may_join(part) ? fetches_[entry].find(key) : kNone;
  }
  /// A fetch for lane `first` begins. The key must not be under way.
  void begin(LaneId first, std::uint64_t key, NodePart part) {
    if (!may_join(part)) return;
    fetches_[entry_of(first)].insert(key, first);
    if (!in_flight_) begun_.push_back(key);
  }
  /// The data of the fetch that began for lane `first` have come.
  void end(LaneId first, std::uint64_t key) {
    AddressIndex& fetches = fetches_[entry_of(first)];
    if (in_flight_ && fetches.find(key) == first) fetches.erase(key);
  }

 private:
  // Unique, because nodes are at least 32 B apart. other: the second of two fetches of the same node.
  static std::uint64_t number(std::uint64_t address, bool other) {
    return address / traces::kQuantisedUnit << 1 | (other ? 1u : 0u);
  }
  // A second read begins long after its warp was selected.
  bool may_join(NodePart part) const { return in_flight_ || part != NodePart::second; }

  bool in_flight_;
  std::vector<AddressIndex> fetches_;  ///< [entry] key -> first lane
  std::vector<std::uint64_t> begun_;   ///< without in_flight: keys of the selected warp's fetches
  unsigned entry_ = 0;                 ///< and its entry
};

}  // namespace grtx::modules
