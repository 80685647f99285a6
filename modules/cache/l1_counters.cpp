// Sums and names of the L1 cache's counters.
#include "grtx/modules/cache/l1_cache.h"

namespace grtx::modules {
namespace {

void add(L1Counters::ByRegion* sum, const L1Counters::ByRegion& r) {
  sum->reads += r.reads;
  sum->hits += r.hits;
  sum->hits_on_miss += r.hits_on_miss;
  sum->misses += r.misses;
  sum->writes += r.writes;
  sum->write_hits += r.write_hits;
}

void describe_region(StatisticList& list, const std::string& prefix, const L1Counters::ByRegion& r) {
  list.add(prefix + ".reads", r.reads, "sectors", "demand reads accepted");
  list.add(prefix + ".hits", r.hits, "sectors", "demand reads whose sector was present");
  list.add(prefix + ".hits_on_miss", r.hits_on_miss, "sectors", "demand reads merged into a pending MSHR");
  list.add(prefix + ".misses", r.misses, "sectors", "demand reads that allocated an MSHR");
  list.add(prefix + ".hit_rate", ratio(r.hits, r.reads), "1", "hits / reads; merged reads are not hits");
  list.add(prefix + ".writes", r.writes, "sectors", "writes, all forwarded to the L2");
  list.add(prefix + ".write_hits", r.write_hits, "sectors", "writes whose sector was present");
}

}  // namespace

L1Counters::ByRegion L1Counters::all() const {
  ByRegion sum;
  for (const ByRegion& r : region) add(&sum, r);
  return sum;
}

L1Counters::ByRegion L1Counters::nodes() const {
  ByRegion sum;
  for (std::size_t i = 0; i < kRegionCount; ++i) {
    if (is_node(static_cast<Region>(i))) add(&sum, region[i]);
  }
  return sum;
}

L1Counters::ByRegion L1Counters::shader_data() const {
  ByRegion sum;
  for (std::size_t i = 0; i < kRegionCount; ++i) {
    if (is_shader_data(static_cast<Region>(i))) add(&sum, region[i]);
  }
  return sum;
}

std::uint64_t L1Counters::accesses() const {
  const ByRegion sum = all();
  return sum.reads + sum.writes + prefetches;
}

L1Counters& L1Counters::operator+=(const L1Counters& o) {
  for (std::size_t i = 0; i < kRegionCount; ++i) add(&region[i], o.region[i]);
  for (std::size_t i = 0; i < stalls.size(); ++i) stalls[i] += o.stalls[i];
  prefetches += o.prefetches;
  prefetches_redundant += o.prefetches_redundant;
  prefetches_fetched += o.prefetches_fetched;
  prefetches_useful += o.prefetches_useful;
  prefetches_late += o.prefetches_late;
  prefetches_unused += o.prefetches_unused;
  responses += o.responses;
  fills += o.fills;
  evictions += o.evictions;
  sent_reads += o.sent_reads;
  sent_writes += o.sent_writes;
  mshr_cycles += o.mshr_cycles;
  miss_latency.merge(o.miss_latency);
  return *this;
}

void L1Counters::describe(StatisticList& list, const std::string& prefix) const {
  list.add(prefix + ".accesses", accesses(), "sectors", "requests accepted: demand reads, writes and prefetches");
  list.add(prefix + ".responses", responses, "sectors", "responses given, one for each request");
  describe_region(list, prefix + ".all", all());
  describe_region(list, prefix + ".node", nodes());
  describe_region(list, prefix + ".shader_data", shader_data());
  for (std::size_t i = 0; i < kRegionCount; ++i) {
    if (region[i].reads + region[i].writes == 0) continue;
    describe_region(list, prefix + '.' + std::string(kRegionNames[i]), region[i]);
  }
  for (std::size_t i = 0; i < stalls.size(); ++i) {
    list.add(prefix + ".stall." + std::string(kL1StallNames[i]), stalls[i], "client-cycles",
             "a client's request was not accepted for this reason");
  }
  list.add(prefix + ".prefetch.requests", prefetches, "sectors", "prefetches accepted");
  list.add(prefix + ".prefetch.redundant", prefetches_redundant, "sectors", "prefetched sector was present or pending");
  list.add(prefix + ".prefetch.fetched", prefetches_fetched, "sectors", "prefetches that allocated an MSHR");
  list.add(prefix + ".prefetch.useful", prefetches_useful, "sectors", "first demand access found the sector present");
  list.add(prefix + ".prefetch.late", prefetches_late, "sectors", "first demand access found the sector pending");
  list.add(prefix + ".prefetch.unused", prefetches_unused, "sectors", "never referenced by a demand access");
  list.add(prefix + ".fills", fills, "sectors", "sectors filled from the L2");
  list.add(prefix + ".evictions", evictions, "lines", "lines replaced");
  list.add(prefix + ".sent_reads", sent_reads, "sectors", "read misses sent to the L2");
  list.add(prefix + ".sent_writes", sent_writes, "sectors", "writes sent to the L2");
  list.add(prefix + ".mshr_cycles", mshr_cycles, "entry-cycles", "occupied MSHR entries summed over cycles");
  list.add(prefix + ".miss_latency", miss_latency.mean(), "cycles", "mean from MSHR allocation to fill");
  list.add(prefix + ".miss_latency_max", miss_latency.max(), "cycles", "longest from MSHR allocation to fill");
}

}  // namespace grtx::modules
