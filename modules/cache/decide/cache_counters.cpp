// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/cache/decide/cache_counters.h"

namespace grtx::modules {
namespace {

CounterTable<RegionCounters> region_table(const RegionWords& words) {
  using C = RegionCounters;
  return CounterTable<C>()
      .sum(&C::reads, "reads", "sectors", words.reads)
      .sum(&C::hits, "hits", "sectors", words.hits)
      .sum(&C::hits_on_miss, "hits_on_miss", "sectors", words.hits_on_miss)
      .sum(&C::misses, "misses", "sectors", words.misses)
      .share({"hits", &C::hits}, {"reads", &C::reads}, "hit_rate", "1", "hits / reads; merged reads are not hits")
      .sum(&C::writes, "writes", "sectors", words.writes)
      .sum(&C::write_hits, "write_hits", "sectors", "writes whose sector was present");
}

template <typename Keep>
RegionCounters sum_of(const CacheRegions& regions, Keep&& keep) {
  RegionCounters sum;
  for (std::size_t i = 0; i < kRegionCount; ++i) {
    if (keep(static_cast<Region>(i))) sum += regions.region[i];
  }
  return sum;
}

}  // namespace

// Direct, not through a CounterTable: observers sum regions while a simulation runs.
RegionCounters& RegionCounters::operator+=(const RegionCounters& r) {
  reads += r.reads;
  hits += r.hits;
  hits_on_miss += r.hits_on_miss;
  misses += r.misses;
  writes += r.writes;
  write_hits += r.write_hits;
  return *this;
}

RegionCounters CacheRegions::all() const {
  return sum_of(*this, [](Region) { return true; });
}
RegionCounters CacheRegions::nodes() const { return sum_of(*this, is_node); }
RegionCounters CacheRegions::shader_data() const { return sum_of(*this, is_shader_data); }

void describe_regions(const CacheRegions& regions, const RegionWords& words, StatisticList& list,
                      const std::string& prefix) {
  const CounterTable<RegionCounters> table = region_table(words);
  table.describe(regions.all(), list, prefix + ".all");
  table.describe(regions.nodes(), list, prefix + ".node");
  table.describe(regions.shader_data(), list, prefix + ".shader_data");
  if (list.is_reference()) return table.describe({}, list, prefix + ".<region>");
  for (std::size_t i = 0; i < kRegionCount; ++i) {
    const RegionCounters& r = regions.region[i];
    if (r.reads + r.writes > 0) table.describe(r, list, prefix + "." + std::string(name_at<Region>(i)));
  }
}

}  // namespace grtx::modules
