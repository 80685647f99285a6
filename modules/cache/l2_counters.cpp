// Sums and names of the L2 slices' counters.
#include "grtx/modules/cache/l2_slice.h"

namespace grtx::modules {
namespace {

void add(L2Counters::ByRegion* sum, const L2Counters::ByRegion& r) {
  sum->reads += r.reads;
  sum->hits += r.hits;
  sum->hits_on_miss += r.hits_on_miss;
  sum->misses += r.misses;
  sum->writes += r.writes;
  sum->write_hits += r.write_hits;
}

void describe_region(StatisticList& list, const std::string& prefix, const L2Counters::ByRegion& r) {
  list.add(prefix + ".reads", r.reads, "sectors", "reads from the L1s");
  list.add(prefix + ".hits", r.hits, "sectors", "reads whose sector was present");
  list.add(prefix + ".hits_on_miss", r.hits_on_miss, "sectors", "reads merged into a pending MSHR");
  list.add(prefix + ".misses", r.misses, "sectors", "reads that went to DRAM");
  list.add(prefix + ".hit_rate", ratio(r.hits, r.reads), "1", "hits / reads; merged reads are not hits");
  list.add(prefix + ".writes", r.writes, "sectors", "writes from the L1s");
  list.add(prefix + ".write_hits", r.write_hits, "sectors", "writes whose sector was present");
}

}  // namespace

L2Counters::ByRegion L2Counters::all() const {
  ByRegion sum;
  for (const ByRegion& r : region) add(&sum, r);
  return sum;
}

L2Counters::ByRegion L2Counters::nodes() const {
  ByRegion sum;
  for (std::size_t i = 0; i < kRegionCount; ++i) {
    if (is_node(static_cast<Region>(i))) add(&sum, region[i]);
  }
  return sum;
}

L2Counters::ByRegion L2Counters::shader_data() const {
  ByRegion sum;
  for (std::size_t i = 0; i < kRegionCount; ++i) {
    if (is_shader_data(static_cast<Region>(i))) add(&sum, region[i]);
  }
  return sum;
}

std::uint64_t L2Counters::accesses() const {
  const ByRegion sum = all();
  return sum.reads + sum.writes;
}

L2Counters& L2Counters::operator+=(const L2Counters& o) {
  for (std::size_t i = 0; i < kRegionCount; ++i) add(&region[i], o.region[i]);
  for (std::size_t i = 0; i < stalls.size(); ++i) stalls[i] += o.stalls[i];
  requests_in += o.requests_in;
  replies_out += o.replies_out;
  dram_reads += o.dram_reads;
  dram_writes += o.dram_writes;
  evictions += o.evictions;
  mshr_cycles += o.mshr_cycles;
  miss_latency.merge(o.miss_latency);
  return *this;
}

void L2Counters::describe(StatisticList& list, const std::string& prefix) const {
  const ByRegion sum = all();
  list.add(prefix + ".accesses", accesses(), "sectors", "reads and writes from the L1s");
  list.add(prefix + ".hit_rate", ratio(sum.hits + sum.write_hits, accesses()), "1",
           "reads and writes whose sector was present / accesses; merged reads are not hits");
  list.add(prefix + ".read_hit_rate", ratio(sum.hits, sum.reads), "1", "read hits / reads");
  describe_region(list, prefix + ".all", sum);
  describe_region(list, prefix + ".node", nodes());
  describe_region(list, prefix + ".shader_data", shader_data());
  for (std::size_t i = 0; i < kRegionCount; ++i) {
    if (region[i].reads + region[i].writes == 0) continue;
    describe_region(list, prefix + '.' + std::string(kRegionNames[i]), region[i]);
  }
  for (std::size_t i = 0; i < stalls.size(); ++i) {
    list.add(prefix + ".stall." + std::string(kL2StallNames[i]), stalls[i], "cycles",
             "an access or fill waited for this reason");
  }
  list.add(prefix + ".dram_reads", dram_reads, "sectors", "sectors read from DRAM");
  list.add(prefix + ".dram_writes", dram_writes, "sectors", "dirty sectors written back to DRAM");
  list.add(prefix + ".evictions", evictions, "lines", "lines replaced");
  list.add(prefix + ".mshr_cycles", mshr_cycles, "entry-cycles", "occupied MSHR entries summed over cycles");
  list.add(prefix + ".miss_latency", miss_latency.mean(), "cycles", "mean from MSHR allocation to fill");
  list.add(prefix + ".miss_latency_max", miss_latency.max(), "cycles", "longest from MSHR allocation to fill");
}

}  // namespace grtx::modules
