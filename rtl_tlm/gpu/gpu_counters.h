// SPDX-License-Identifier: Apache-2.0
// All counters of a GPU's units, per unit and summed, and their description as statistics.
#pragma once

#include <vector>

#include "grtx/modules/cache/decide/l1_cache_config.h"
#include "grtx/modules/cache/decide/l2_slice_config.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/rt_unit/rt_unit_counters.h"
#include "grtx/modules/simt/decide/simt_core_config.h"
#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/gpu/memory_system.h"

namespace grtx::sim {

struct GpuCounters {
  Cycle cycles = 0;                            ///< core cycles until the last warp had ended
  std::vector<modules::RtUnitCounters> rt_of;  ///< by RT unit; those of an SM are adjacent
  std::vector<modules::SimtCounters> simt_of;
  std::vector<modules::L1Counters> l1_of;
  std::vector<modules::L2Counters> l2_of;
  modules::RtUnitCounters rt;
  modules::SimtCounters simt;
  modules::L1Counters l1;
  modules::L2Counters l2;
  modules::CrossbarCounters crossbar;
  std::uint64_t period_fs = 0;  ///< of the core clock
  modules::DistributorCounters distributor;
  std::uint64_t l2_dirty_sectors = 0;  ///< in the L2 at the end
  MemoryCounters memory;
};

/// Counters that are read when the last warp has ended: prefetches and write-backs, which drain then, are no part of
/// them.
struct SettledCounters {
  std::vector<modules::RtUnitCounters> rt_of;
  double memory_busy_cycles = 0.0;
};
/// Closes the per-cycle counts of the RT units and reads them.
SettledCounters settle(Gpu& gpu, const MemorySystem& memory);
/// Reads all counters after draining. Per-cycle counts of RT units and the DRAM's busy cycles are taken from `end`.
GpuCounters collect_counters(const Gpu& gpu, const MemorySystem& memory, const SettledCounters& end);
/// Sums the counters of SMs, RT units and slices.
void add_up(GpuCounters& counters);

/// gpu.cycles, gpu.time_us, and the statistics of all modules, summed over SMs and slices.
void describe(const GpuCounters& counters, modules::StatisticList& list);

}  // namespace grtx::sim
