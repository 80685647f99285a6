// gpu.energy_nj and its parts as statistics of a run: what the cost model makes of the run's own counts.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

/// Adds gpu.energy_nj, its share by group of hardware (gpu.energy_nj.rt, .simt, .l1, .crossbar, .l2, .dram, .leakage),
/// its band (gpu.energy_nj_low, _high) and gpu.energy_nj_per_ray to `list`, which must hold the counts of the run
/// (gpu.*) already. inventories: of the machine that ran. rays: primary and secondary, at least 1.
/// Process node and prices are the defaults of CostOptions and EnergyOptions (12 nm, GDDR6). Every part is rounded to
/// whole picojoules and the totals are sums of those integers: the same for every compiler.
void describe_energy(const GpuConfig& config, const std::vector<modules::Inventory>& inventories, std::uint64_t rays,
                     modules::StatisticList& list);

}  // namespace grtx::sim
