// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/conservation.h"

#include <fmt/format.h>

#include <functional>
#include <numeric>

#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/rt_unit/rt_unit_table.h"
#include "grtx/modules/rt_unit/scheduler/rt_scheduler.h"
#include "grtx/modules/tlm/at_payload_pool.h"

namespace grtx::sim {

namespace {

using Equal = std::function<void(const std::string& what, std::uint64_t executed, std::uint64_t expected)>;

/// Node sectors that units at the node ports answered themselves.
std::uint64_t kept_nodes(const GpuCounters& c) {
  std::uint64_t kept = 0;
  for (const modules::PartInfo& part : modules::part_table({}, {})) kept += c.l1.own.of(part.kept_nodes);
  return kept;
}

/// Accesses to each memory region, from the unit that makes them down to the DRAM.
void check_regions(const GpuCounters& c, const Equal& equal) {
  using modules::index;
  using modules::Region;
  const modules::RegionCounters &checkpoint = c.l1.region[index(Region::checkpoint)],
                                &stack = c.l1.region[index(Region::stack)];
  equal("L1 writes of checkpoint entries", checkpoint.writes, c.rt.checkpoint.sectors_written);
  equal("L1 reads of checkpoint entries", checkpoint.reads, c.rt.checkpoint.sectors_read);
  equal("L1 writes of stack entries", stack.writes, c.rt.stack.spills);
  equal("L1 reads of stack entries", stack.reads, c.rt.stack.fills);
  equal("L1 reads of nodes", c.l1.nodes().reads, c.rt.memory.node_sectors() - kept_nodes(c));
  for (const Region region : {Region::k_buffer, Region::eviction, Region::gaussian, Region::sh, Region::ray}) {
    const std::size_t i = index(region);
    const std::string of = " of region " + std::string(name_at<modules::Region>(i));
    equal("L1 reads" + of, c.l1.region[i].reads, c.simt.memory.loads[i]);
    equal("L1 writes" + of, c.l1.region[i].writes, c.simt.memory.stores[i]);
  }
  // The L2 also reads prefetches of nodes and checkpoint entries: these regions are only checked in total.
  std::uint64_t l1_misses = 0, l2_reads = 0, l2_writes = 0, dram_reads = 0, dram_writes = 0;
  for (std::size_t i = 0; i < modules::kRegionCount; ++i) {
    const auto region = static_cast<Region>(i);
    const std::string name(name_at<modules::Region>(i));
    const modules::RegionCounters &l1 = c.l1.region[i], &l2 = c.l2.region[i];
    if (!is_node(region) && region != Region::checkpoint) equal("L2 reads of region " + name, l2.reads, l1.misses);
    equal("DRAM reads of region " + name, c.l2.dram_reads_of[i], l2.misses);
    l1_misses += l1.misses;
    l2_reads += l2.reads;
    l2_writes += l2.writes;
    dram_reads += c.l2.dram_reads_of[i];
    dram_writes += c.l2.dram_writes_of[i];
    if (c.l1.kept_writes == 0 && c.l1.write_backs == 0 && c.l1.sent_writes != 0) {
      equal("L2 writes of region " + name, l2.writes, l1.writes);
    }
  }
  equal("L2 reads of all regions", l2_reads, l1_misses + c.l1.prefetches_fetched);
  equal("L2 writes of all regions", l2_writes, c.l1.sent_writes);
  equal("DRAM reads of all regions", dram_reads, c.l2.dram_reads);
  equal("DRAM writes of all regions", dram_writes, c.l2.dram_writes);
}

/// The work of the trace was done, each piece once.
void check_work(const GpuCounters& c, const traces::Totals& totals, std::uint64_t groups, const Equal& equal) {
  const modules::RtScheduler::Counters& events = c.rt.scheduler;
  equal("warps ended", c.simt.warps, groups);
  equal("ray rounds executed", c.simt.shader.ray_rounds, totals.rounds);
  equal("internal node visits", events.visits_internal, totals.visits_internal);
  equal("instance leaf visits", events.visits_instance, totals.visits_instance);
  equal("primitive leaf visits", events.visits_leaf, totals.visits_leaf);
  equal("node visits fetched", c.rt.memory.node_visits(), totals.visits());
  equal("culls", events.culls, totals.culls);
  equal("any-hit calls of the RT units", events.any_hit_calls, totals.any_hit_calls);
  const modules::AnyHitUnitCounters& heaps = c.rt.any_hit.unit;
  equal("hits of SIMT cores and any-hit units", c.simt.shader.any_hit_calls + heaps.hits, totals.any_hit_calls);
  equal("hits answered by any-hit units", heaps.answers, heaps.hits);
  const bool boxes = events.intersection_calls != 0;
  equal("batches of calls at the SIMT cores",
        boxes ? c.simt.shader.intersection_batches : c.simt.shader.any_hit_batches, c.rt.any_hit.batches);
  equal("intersection calls of the RT units", events.intersection_calls, boxes ? totals.visits_leaf : 0);
  equal("intersection calls of the SIMT cores", c.simt.shader.intersection_calls, events.intersection_calls);
  equal("evictions", c.simt.shader.evictions, totals.evictions);
  equal("checkpoints written", c.rt.checkpoint.entries_written, totals.checkpoints_written);
  equal("checkpoints read", c.rt.checkpoint.entries_read, totals.checkpoints_read);
  equal("source entries taken or forwarded", events.replay_takes + events.replay_forwards, totals.checkpoints_read);
  equal("k-buffer entries processed", c.simt.shader.entries_processed, totals.processed);
  equal("k-buffer entries blended", c.simt.shader.entries_blended, totals.blended);
  equal("k-buffer mismatches", c.simt.shader.k_buffer_mismatches, 0);
  equal("traceRay calls accepted", c.rt.warp_buffer.calls, c.simt.shader.warp_rounds);
}

/// Requests and responses, level by level.
void check_traffic(const GpuCounters& c, const Equal& equal) {
  const std::uint64_t rt_requests = c.rt.memory.node_sectors() - c.rt.memory.shader_sectors + c.rt.stack.spills +
                                    c.rt.stack.fills + c.rt.checkpoint.sectors_read + c.rt.checkpoint.sectors_written +
                                    c.rt.prefetch.sectors - kept_nodes(c);
  equal("L1 accesses", c.l1.accesses(), rt_requests + c.simt.memory.sectors());
  equal("L1 responses", c.l1.responses, c.l1.accesses());
  equal("checkpoint writes acknowledged", c.rt.checkpoint.acknowledged, c.rt.checkpoint.sectors_written);
  equal("checkpoint reads returned", c.rt.checkpoint.returned, c.rt.checkpoint.sectors_read);
  equal("stack spills acknowledged", c.rt.stack.acknowledged, c.rt.stack.spills);
  equal("stack fills returned", c.rt.stack.returned, c.rt.stack.fills);
  equal("stack entries filled", c.rt.stack.moved_in, c.rt.stack.moved_out);
  equal("prefetches answered", c.rt.prefetch.responses, c.rt.prefetch.sectors);
  equal("L1 fills", c.l1.fills, c.l1.sent_reads);
  equal("packets into the request network", c.crossbar.request.packets_in, c.l1.sent_reads + c.l1.sent_writes);
  equal("packets out of the request network", c.crossbar.request.packets_out, c.crossbar.request.packets_in);
  equal("L2 requests", c.l2.requests_in, c.crossbar.request.packets_out);
  equal("L2 accesses", c.l2.accesses(), c.l2.requests_in);
  equal("L2 replies", c.l2.replies_out, c.l2.requests_in);
  equal("packets into the reply network", c.crossbar.reply.packets_in, c.l2.replies_out);
  equal("packets out of the reply network", c.crossbar.reply.packets_out, c.crossbar.reply.packets_in);
  const MemoryTraffic& memory = c.memory.traffic;
  equal("DRAM reads", memory.reads, c.l2.dram_reads);
  equal("DRAM writes", memory.writes, c.l2.dram_writes);
  equal("DRAM responses", memory.responses, c.l2.dram_reads + c.l2.dram_writes);
  equal("DRAM refusals", memory.refused, 0);
}

}  // namespace

std::vector<std::string> count_violations(const GpuCounters& c, const traces::Totals& totals, std::uint64_t groups) {
  std::vector<std::string> violations;
  const Equal equal = [&](const std::string& what, std::uint64_t executed, std::uint64_t expected) {
    if (executed != expected) violations.push_back(fmt::format("{}: {} instead of {}", what, executed, expected));
  };
  check_work(c, totals, groups, equal);
  check_traffic(c, equal);
  check_regions(c, equal);

  // Every cycle of every RT unit is a selection or has one stall reason.
  const modules::RtScheduler::Counters& events = c.rt.scheduler;
  const std::uint64_t stalls = std::accumulate(events.stall.begin(), events.stall.end(), std::uint64_t{0});
  equal("RT unit cycles accounted for", events.selections + stalls, c.rt.units * c.cycles);
  // Every cycle of every warp in a buffer has one reason.
  const auto& waits = c.rt.warp_buffer.warp_cycles;
  equal("warp cycles accounted for", std::accumulate(waits.begin(), waits.end(), std::uint64_t{0}),
        c.rt.warp_buffer.occupancy_integral);
  return violations;
}

std::vector<std::string> emptiness_violations(const Gpu& gpu, const MemorySystem& memory) {
  std::vector<std::string> violations;
  if (!gpu.idle()) violations.push_back("the GPU is not empty at the end");
  if (!memory.idle()) violations.push_back("the DRAM is not empty at the end");
  for (const auto& sm : gpu.sms()) {
    const auto* own = dynamic_cast<const modules::L1Cache*>(&sm->l1());
    if (own == nullptr) continue;
    const modules::L1Counters l1 = own->counters();
    if (own->dirty_at_start() + l1.kept_writes != l1.rewrites + l1.write_backs + own->dirty_sectors()) {
      violations.push_back(fmt::format("{}: {} sectors kept, {} of them again, {} written back, {} dirty", own->name(),
                                       l1.kept_writes, l1.rewrites, l1.write_backs, own->dirty_sectors()));
    }
  }
  for (const auto& slice : gpu.slices()) {
    const auto* own = dynamic_cast<const modules::L2Slice*>(slice.get());
    if (own != nullptr && own->dram.pool().live() != 0)
      violations.push_back(std::string(slice->name()) + ": DRAM payloads are still held");
  }
  return violations;
}

std::vector<std::string> bound_violations(Cycle cycles, const std::vector<LowerBound>& bounds) {
  std::vector<std::string> violations;
  for (const LowerBound& bound : bounds) {
    if (cycles < bound.cycles) {
      violations.push_back(
          fmt::format("{} cycles are below the lower bound {} of {}", cycles, bound.name, bound.cycles));
    }
  }
  return violations;
}

}  // namespace grtx::sim
