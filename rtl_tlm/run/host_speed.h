// SPDX-License-Identifier: Apache-2.0
// Simulation speed on the host: the same figures for every mode, including those that other simulators report.
#pragma once

#include <cstdint>

#include "grtx/base/strong.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

struct HostWork {
  Cycle cycles = 0;          ///< of the core clock, simulated or estimated
  std::uint64_t visits = 0;  ///< of nodes, by lanes
  double wall_seconds = 0.0;
  double cpu_seconds = 0.0;  ///< of all threads and processes
};

/// Adds host.cycles_per_second and its like.
void add_host_speed(modules::StatisticList& host, const HostWork& work, const GpuConfig& config);

}  // namespace grtx::sim
