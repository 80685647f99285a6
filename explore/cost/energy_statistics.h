// SPDX-License-Identifier: Apache-2.0
// gpu.energy_nj and its parts: energy statistics of a run, computed by the cost model from the run's counters.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::explore {

/// Adds gpu.energy_nj, its share by group of hardware (gpu.energy_nj.rt, .simt, .l1, .crossbar, .l2, .dram, .leakage),
/// its band (gpu.energy_nj_low, _high) and gpu.energy_nj_per_ray to `list`, which must already hold the run's counters
/// (gpu.*). inventories: of the machine that ran. rays: primary plus secondary, at least 1. Process node and prices are
/// the defaults of CostOptions and EnergyOptions (12 nm, GDDR6). Every part is rounded to whole picojoules so that the
/// totals do not depend on the compiler.
void describe_energy(const sim::GpuConfig& config, const std::vector<modules::Inventory>& inventories,
                     std::uint64_t rays, modules::StatisticList& list);

}  // namespace grtx::explore
