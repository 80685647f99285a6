// SPDX-License-Identifier: Apache-2.0
// Result of a run in windows mode, and the statistics of its confidence interval.
#pragma once

#include <map>
#include <string>

#include "grtx/rtl_tlm/estimate/estimate.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace grtx::sim {

struct EstimatedResult {
  SimulationResult result;  ///< of the whole run, estimated; document: gpu.windows.* in "stats", estimate in "windows"
  CycleEstimate estimate;
  ConfidenceInterval cycles;
  std::map<std::string, StatisticInterval> intervals;  ///< of the statistics that are not exact; "windows.intervals"
};

/// Adds gpu.windows.*: the interval on gpu.cycles, its deviation, drift and confidence.
void describe_interval(const EstimatedResult& result, modules::StatisticList& list);
/// Fills estimate and interval of a run that was simulated completely: exact, an interval of zero width.
void make_whole(EstimatedResult& result);

/// Adds `statistics` (in front of host.*), the inputs and the estimate to the document of a finished run.
void add_to_document(const modules::StatisticList& statistics, EstimatedResult& result);

/// simulate() in a child process, so that it may be called repeatedly. Fills document, violations, notes, inputs,
/// cycles and binding_bound of the result.
SimulationResult simulate_in_child(const std::string& trace_path, const GpuConfig& config,
                                   const SimulationOptions& options);

}  // namespace grtx::sim
