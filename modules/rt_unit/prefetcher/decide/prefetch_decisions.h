// SPDX-License-Identifier: Apache-2.0
// Decisions of the RT unit's sibling prefetcher: which siblings of a leaf to prefetch, and whether each is queued,
// merged with a queued one, or dropped. Used by both the timed and the functional path.
#pragma once

#include <bit>
#include <cstdint>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/modules/rt_unit/prefetcher/decide/prefetcher_config.h"
#include "grtx/modules/rt_unit/prefetcher/decide/sibling_records.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

/// Which accesses trigger prefetches.
struct PrefetchTriggers {
  bool siblings = true;   ///< leaf visits
  bool replayed = false;  ///< also visits of replayed leaves
};

/// Decisions for all lanes. A Queue has waits(address), full() and push(kind, address); addresses in bytes.
class PrefetchDecisions {
 public:
  /// traffic must outlive it.
  PrefetchDecisions(std::size_t lanes, const PrefetcherConfig& config, const PrefetchTriggers& triggers,
                    const NodeTraffic& traffic)
      : triggers_(triggers), traffic_(traffic), records_(lanes, config.records, triggers.replayed, traffic) {}

  // As in prefetch_if. ray: number of the lane's ray.
  void begin_lane(std::size_t lane, std::size_t ray, bool replays) { records_.begin(lane, ray, replays); }
  void begin_warp() { asked_.begin(); }
  void note_internal(std::size_t lane, const traces::RayGroup& group, std::uint32_t definition, unsigned hit,
                     unsigned checkpointed) {
    if (triggers_.siblings) records_.note(lane, group, definition, hit, checkpointed);
  }
  void note_replayed(std::size_t lane, std::uint32_t address) { records_.note_replayed(lane, address); }
  /// The lane visits the leaf at `address` (in units). Returns the siblings to prefetch.
  Siblings take(std::size_t lane, const traces::RayGroup& group, std::uint32_t address) {
    return records_.take(lane, group, address);
  }
  template <typename Queue>
  void ask_for(const Siblings& siblings, const traces::RayGroup& group, Queue&& queue) {
    ++counters_.triggers;
    if (siblings.replayed) ++counters_.replayed;
    const unsigned fresh = asked_.fresh(siblings);
    counters_.merged += static_cast<unsigned>(std::popcount(siblings.mask & ~fresh));
    records_.for_each_child(group.nodes[siblings.definition], fresh, [&](traces::NodeKind kind, std::uint32_t child) {
      const std::uint64_t address = traffic_.address(child);
      push(queue, kind, address, counters_.nodes, counters_.merged, counters_.dropped);
    });
  }

  const PrefetchTriggers& triggers() const { return triggers_; }
  const SiblingRecords& records() const { return records_; }
  PrefetchCounters& counters() { return counters_; }
  const PrefetchCounters& counters() const { return counters_; }

 private:
  template <typename Queue>
  void push(Queue& queue, traces::NodeKind kind, std::uint64_t address, std::uint64_t& pushed, std::uint64_t& merged,
            std::uint64_t& dropped) {
    if (queue.waits(address)) {
      ++merged;
    } else if (queue.full()) {
      ++dropped;
    } else {
      queue.push(kind, address);
      ++pushed;
    }
  }

  PrefetchTriggers triggers_;
  const NodeTraffic& traffic_;
  SiblingRecords records_;
  SiblingRequests asked_;
  PrefetchCounters counters_;
};

}  // namespace grtx::modules
