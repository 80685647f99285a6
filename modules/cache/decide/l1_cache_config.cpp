// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/cache/decide/l1_cache_config.h"

namespace grtx::modules {

std::uint64_t L1Counters::accesses() const {
  const RegionCounters sum = all();
  return sum.reads + sum.writes + prefetches;
}

const CounterTable<L1Counters>& L1Counters::table() {
  using C = L1Counters;
  const auto regions = [](const C& c, StatisticList& list, const std::string& prefix) {
    describe_regions(
        c,
        {"demand reads accepted", "demand reads whose sector was present", "demand reads merged into a pending MSHR",
         "demand reads that allocated an MSHR", "writes accepted"},
        list, prefix);
  };
  static const CounterTable<C> table =
      CounterTable<C>()
          .value(&C::accesses, "accesses", "sectors", "requests accepted: demand reads, writes and prefetches",
                 StatisticKind::count)
          .sum(&C::responses, "responses", "sectors", "responses given, one for each request")
          .own(&C::region, add_regions)
          .described(regions)
          .by_name<L1Stall>(&C::stalls, "stall", "client-cycles", "a client's request was not accepted for this reason")
          .sum(&C::prefetches, "prefetch.requests", "sectors", "prefetches accepted")
          .sum(&C::prefetches_redundant, "prefetch.redundant", "sectors", "prefetched sector was present or pending")
          .sum(&C::prefetches_fetched, "prefetch.fetched", "sectors", "prefetches that allocated an MSHR")
          .sum(&C::prefetches_useful, "prefetch.useful", "sectors", "first demand access found the sector present")
          .sum(&C::prefetches_late, "prefetch.late", "sectors", "first demand access found the sector pending")
          .sum(&C::prefetches_unused, "prefetch.unused", "sectors", "never referenced by a demand access")
          .sum(&C::fills, "fills", "sectors", "sectors filled from the L2")
          .sum(&C::fills_bypassed, "fills_bypassed", "sectors",
               "of these, not kept: all lines of the set dirty, and no room in the write-back buffer")
          .sum(&C::evictions, "evictions", "lines", "lines replaced")
          .sum(&C::kept_writes, "kept_writes", "sectors", "writes that stayed in the L1, dirty")
          .sum(&C::rewrites, "rewrites", "sectors", "of these, sectors that were dirty already")
          .sum(&C::write_backs, "write_backs", "sectors", "dirty sectors written back when their line was evicted")
          .sum(&C::sent_reads, "sent_reads", "sectors", "read misses sent to the L2")
          .sum(&C::sent_writes, "sent_writes", "sectors", "writes sent to the L2: through and back")
          .sum(&C::mshr_cycles, "mshr_cycles", "entry-cycles", "occupied MSHR entries summed over cycles")
          .distribution(&C::miss_latency, "miss_latency", "cycles", "mean from MSHR allocation to fill",
                        "longest from MSHR allocation to fill")
          .own_counts(&C::own);
  return table;
}

}  // namespace grtx::modules
