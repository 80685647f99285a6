// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/gpu/gpu_counters.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/simt/simt_core.h"

namespace grtx::sim {
namespace {

using modules::Distribution;
using modules::Quotient;
using modules::StatisticKind;
using modules::StatisticList;

/// One statistic for each power of two up to the largest value seen.
void add_histogram(StatisticList& list, const std::string& name, const Distribution& distribution,
                   const std::string& unit, const std::string& what) {
  unsigned last = 0;
  for (unsigned i = 0; i < Distribution::kBins; ++i) {
    if (distribution.bin(i) != 0) last = i;
  }
  for (unsigned i = 0; i <= last; ++i) {
    const std::uint64_t low = i == 0 ? 0 : std::uint64_t{1} << (i - 1);
    const std::uint64_t high = i == 0 ? 0 : 2 * low - 1;
    list.add(fmt::format("{}.from_{}", name, low), distribution.bin(i), unit,
             fmt::format("{} of {} to {} cycles", what, low, high), StatisticKind::histogram);
  }
}

/// Cycles of each frame of a sequence; a run of one frame has none of them.
void describe_frames(const std::vector<modules::LaunchSpan>& launches, StatisticList& list) {
  if (launches.empty() || (launches.back().frame == 0 && !list.is_reference())) return;
  Cycle start = 0;
  for (std::size_t i = 0; i < launches.size(); ++i) {
    if (i + 1 < launches.size() && launches[i + 1].frame == launches[i].frame) continue;
    list.add(fmt::format("gpu.frame{}.cycles", launches[i].frame), launches[i].end - start, "cycles",
             "of this frame of a sequence; caches keep what the previous frame left", StatisticKind::largest);
    start = launches[i].end;
  }
}

}  // namespace

SettledCounters settle(Gpu& gpu, const MemorySystem& memory) {
  SettledCounters end;
  const Cycle cycles = gpu.distributor().end_cycle();
  for (const auto& sm : gpu.sms()) {
    for (const auto& rt : sm->rt_units()) {
      rt->settle(cycles);
      modules::RtUnitCounters& counters = end.rt_of.emplace_back(rt->counters());
      // A unit that ticked in cycle `cycles`, after the run, counted it as empty: all warps had ended.
      if (rt->accounted() > cycles) {
        counters.scheduler.stall[static_cast<std::size_t>(modules::Stall::empty)] -= rt->accounted() - cycles;
      }
    }
  }
  end.memory_busy_cycles = memory.busy_core_cycles();
  return end;
}

GpuCounters collect_counters(const Gpu& gpu, const MemorySystem& memory, const SettledCounters& end) {
  GpuCounters c;
  c.cycles = gpu.distributor().end_cycle();
  for (const auto& sm : gpu.sms()) {
    for (const auto& rt : sm->rt_units()) {
      const modules::RtUnitCounters& at_end = end.rt_of[c.rt_of.size()];
      c.rt_of.push_back(rt->counters());
      c.rt_of.back().scheduler = at_end.scheduler;
      c.rt_of.back().warp_buffer = at_end.warp_buffer;
    }
  }
  for (const auto& sm : gpu.sms()) {
    c.simt_of.push_back(sm->simt().counters());
    c.l1_of.push_back(sm->l1_counters());
  }
  for (const auto& slice : gpu.slices()) c.l2_of.push_back(slice->counters());
  c.crossbar = gpu.crossbar().counters();
  c.period_fs = gpu.core().period_fs();
  c.distributor = gpu.distributor().counters();
  for (const auto& slice : gpu.slices()) c.l2_dirty_sectors += slice->dirty_sectors();
  c.memory = {memory.model(), memory.total(), end.memory_busy_cycles, {}};
  memory.statistics(c.memory.statistics, "gpu.dram");
  add_up(c);
  return c;
}

void add_up(GpuCounters& c) {
  for (const modules::RtUnitCounters& rt : c.rt_of) c.rt.add(rt);
  for (const modules::SimtCounters& simt : c.simt_of) c.simt.add(simt);
  for (const modules::L1Counters& l1 : c.l1_of) c.l1 += l1;
  for (const modules::L2Counters& l2 : c.l2_of) c.l2 += l2;
}

void describe(const GpuCounters& c, StatisticList& list) {
  list.add("gpu.cycles", c.cycles, "cycles", "core cycles from the start to the end of the last warp",
           StatisticKind::largest);
  list.add("gpu.time_us", static_cast<double>(c.cycles) * static_cast<double>(c.period_fs) * 1e-9, "us",
           "simulated time: gpu.cycles at the core clock", StatisticKind::largest);
  list.add("gpu.rays.primary_cycles", modules::cycles_of_kind(c.distributor.launches, false), "cycles",
           "until the last warp of primary rays had ended", StatisticKind::largest);
  list.add("gpu.rays.secondary_cycles", modules::cycles_of_kind(c.distributor.launches, true), "cycles",
           "from then to the end: warps of secondary rays, which are a launch of their own", StatisticKind::largest);
  describe_frames(c.distributor.launches, list);
  describe(c.distributor, list, "gpu.distributor");
  c.rt.describe(list, "gpu.rt", c.cycles);
  add_histogram(list, "gpu.rt.node_fetch_latency.histogram", c.rt.memory.fetch_latency, "fetches", "node fetches");
  add_histogram(list, "gpu.rt.warp_latency.histogram", c.rt.warp_buffer.warp_latency, "calls", "traceRay calls");
  list.add("gpu.rt.merge_factor",
           Quotient{c.rt.memory.node_visits(), c.rt.memory.node_fetches(), "gpu.rt.node_visits", "gpu.rt.node_fetches"},
           "ratio", "lane visits per node fetch", StatisticKind::ratio);
  const std::size_t units = c.rt_of.size() / std::max<std::size_t>(1, c.simt_of.size());
  for (std::size_t i = 0; i < c.simt_of.size(); ++i) {
    for (std::size_t u = 0; u < units; ++u) {
      list.add(fmt::format("gpu.sm{}.rt{}.selections", i, u == 0 ? "" : std::to_string(u)),
               c.rt_of[i * units + u].scheduler.selections, "cycles", "cycles in which this RT unit scheduled a warp",
               StatisticKind::count);
    }
    list.add(fmt::format("gpu.sm{}.warps", i), c.simt_of[i].warps, "warps", "warps that ran on this SM",
             StatisticKind::count);
  }
  describe(c.simt, list, "gpu.simt");
  c.l1.describe(list, "gpu.l1");
  add_histogram(list, "gpu.l1.miss_latency.histogram", c.l1.miss_latency, "misses", "L1 misses");
  describe(c.crossbar, list, "gpu.crossbar");
  c.l2.describe(list, "gpu.l2");
  add_histogram(list, "gpu.l2.miss_latency.histogram", c.l2.miss_latency, "misses", "L2 misses");
  list.add("gpu.l2.dirty_at_end", c.l2_dirty_sectors, "sectors", "dirty sectors left in the L2 when the run ended",
           StatisticKind::state);
  for (const modules::Statistic& s : c.memory.statistics.items()) list.add(s);
}

}  // namespace grtx::sim
