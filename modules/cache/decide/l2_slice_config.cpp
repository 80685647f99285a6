// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/cache/decide/l2_slice_config.h"

namespace grtx::modules {

std::uint64_t L2Counters::accesses() const {
  const RegionCounters sum = all();
  return sum.reads + sum.writes;
}

const CounterTable<L2Counters>& L2Counters::table() {
  using C = L2Counters;
  const auto regions = [](const C& c, StatisticList& list, const std::string& prefix) {
    describe_regions(c,
                     {"reads from the L1s", "reads whose sector was present", "reads merged into a pending MSHR",
                      "reads that went to DRAM", "writes from the L1s"},
                     list, prefix);
  };
  static const CounterTable<C> table =
      CounterTable<C>()
          .value(&C::accesses, "accesses", "sectors", "reads and writes from the L1s", StatisticKind::count)
          .share({"", [](const C& c) { return c.all().hits + c.all().write_hits; }}, {"accesses", &C::accesses},
                 "hit_rate", "1", "reads and writes whose sector was present / accesses; merged reads are not hits")
          .share({"all.hits", [](const C& c) { return c.all().hits; }},
                 {"all.reads", [](const C& c) { return c.all().reads; }}, "read_hit_rate", "1", "read hits / reads")
          .own(&C::region, add_regions)
          .described(regions)
          .by_name<L2Stall>(&C::stalls, "stall", "cycles", "an access or fill waited for this reason")
          .sum(&C::dram_reads, "dram_reads", "sectors", "sectors read from DRAM")
          .sum(&C::dram_writes, "dram_writes", "sectors", "dirty sectors written back to DRAM")
          .by_name<Region>(&C::dram_reads_of, "dram_reads", "sectors", "sectors read from DRAM for {}")
          .by_name<Region>(&C::dram_writes_of, "dram_writes", "sectors",
                           "sectors written back to DRAM, written last by {}")
          .sum(&C::evictions, "evictions", "lines", "lines replaced")
          .sum(&C::mshr_cycles, "mshr_cycles", "entry-cycles", "occupied MSHR entries summed over cycles")
          .distribution(&C::miss_latency, "miss_latency", "cycles", "mean from MSHR allocation to fill",
                        "longest from MSHR allocation to fill")
          .sum(&C::requests_in)
          .sum(&C::replies_out)
          .own_counts(&C::own);
  return table;
}

}  // namespace grtx::modules
