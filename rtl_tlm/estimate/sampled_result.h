// SPDX-License-Identifier: Apache-2.0
// Result of an estimated run (sampled or windows mode), and the statistics of its confidence interval.
#pragma once

#include <string>

#include "grtx/rtl_tlm/estimate/estimate.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace grtx::sim {

struct SampledResult {
  SimulationResult result;  ///< of the whole run, estimated; document: gpu.sampled.* in "stats", estimate in "sampled"
  SampledEstimate estimate;
  ConfidenceInterval cycles;
};

/// Adds gpu.sampled.*: the interval on gpu.cycles, its deviation, bias, degrees of freedom and confidence.
void describe_interval(const SampledResult& result, modules::StatisticList& list);
/// Fills estimate and interval of a run that was simulated completely: exact, an interval of zero width.
void make_whole(SampledResult& result);

/// Adds `statistics` (in front of host.*), the inputs and the estimate to the document of a finished run.
void add_to_document(const modules::StatisticList& statistics, SampledResult& result);

/// simulate() in a child process, so that it may be called repeatedly. Fills document, violations, notes, inputs,
/// cycles, binding_bound and sampled_work of the result.
SimulationResult simulate_in_child(const std::string& trace_path, const GpuConfig& config,
                                   const SimulationOptions& options);

}  // namespace grtx::sim
