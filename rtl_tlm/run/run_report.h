// What a run means: its statistics, lower bounds, and the laws that it broke.
#pragma once

#include <cstdint>

#include "grtx/rtl_tlm/run/measured_source.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace grtx::sim {

/// Fills cycles, statistics, violations, notes and binding_bound of `result` from what a run has left. source: gave
/// it its groups. engine: that ran, or nullptr: cycle by cycle. price: see SimulationOptions.
void report_run(const FinishedRun& finished, const MeasuredSource& source, const GpuConfig& config,
                const Engine* engine, const EnergyPricing& price, SimulationResult& result);

}  // namespace grtx::sim
