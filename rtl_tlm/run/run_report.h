// SPDX-License-Identifier: Apache-2.0
// Evaluates a finished run: statistics, lower bounds, and violated conservation laws.
#pragma once

#include <cstdint>

#include "grtx/rtl_tlm/run/measured_source.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace grtx::sim {

/// Raw data of a finished run.
struct FinishedRun {
  GpuCounters counters;
  std::vector<GpuCounters> at_launches;  ///< see SimulationOptions::read_at
  std::vector<std::string> violations;   ///< found so far: emptiness, memory
  std::vector<modules::Inventory> inventories;
  modules::StatisticList latency;  ///< gpu.latency.*; empty if it was not asked for
  nlohmann::ordered_json over_time;
  std::uint64_t ticks = 0;
  unsigned width = 0, height = 0;  ///< of the image, when pixel_cycles was asked for
  std::vector<std::uint64_t> pixel_cycles;
  std::string units;               ///< with options.save_state: state of caches and open rows
  std::uint64_t memory_bytes = 0;  ///< that all launches needed
};

/// Fills cycles, statistics, violations, notes, bounds, binding_bound and at_launches of `result`. source: gave the run
/// its groups. price: see SimulationOptions.
void report_run(const FinishedRun& finished, const MeasuredSource& source, const GpuConfig& config,
                const EnergyPricing& price, SimulationResult& result);

}  // namespace grtx::sim
