// SPDX-License-Identifier: Apache-2.0
// Parameters and counters of the sibling prefetcher.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/rt_unit/part/part_info.h"

namespace grtx::modules {

/// Counters; table() describes each.
struct PrefetchCounters {
  std::uint64_t triggers = 0, nodes = 0, merged = 0, dropped = 0;  ///< siblings
  std::uint64_t sectors = 0, responses = 0, replayed = 0;
  static const CounterTable<PrefetchCounters>& table();
  void add(const PrefetchCounters& other) { table().add(*this, other); }
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};

struct PrefetcherConfig {
  static constexpr unsigned kMaxRecords = 8;

  unsigned records = 4;   ///< per lane; a new one replaces the oldest
  unsigned queue = 32;    ///< a prefetch is dropped if the queue is full
  bool replayed = false;  ///< a replayed leaf prefetches the siblings that were checkpointed with it
  void parameters(ParameterList& list) {
    list.add("records", records, {1, kMaxRecords}, "nodes", "internal visits remembered per lane", kOurs);
    list.add("queue", queue, {1, kMaxEntries}, "nodes", "prefetches waiting to be issued", kOurs);
    list.add("replayed", replayed, "a replayed leaf brings the siblings that were checkpointed with it",
             assumed("this project: off; GRTX, Section V, says any child leaf node"));
  }
};
/// The part's row in the table of all parts.
PartInfo part_info(const PrefetcherConfig& config);

}  // namespace grtx::modules
