// What an estimated run gives, and the statistics of its interval.
#pragma once

#include <string>

#include "grtx/rtl_tlm/estimate/estimate.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace grtx::sim {

struct SampledResult {
  SimulationResult result;  ///< of the whole run, estimated; its document has gpu.sampled.*, and the estimate as "sampled"
  SampledEstimate estimate;
  ConfidenceInterval cycles;
};

/// Statistics of the interval on gpu.cycles: gpu.sampled.cycles_low and what it rests on.
void describe_interval(const SampledResult& result, modules::StatisticList& list);
/// The same for a whole run, whose interval has no width.
void make_whole(SampledResult& result);

/// Puts the statistics in front of those of the host, and the estimate, into the document of a run that is complete.
void add_to_document(const modules::StatisticList& statistics, SampledResult& result);

/// simulate() in a process of its own: may be called more than once. The document, violations, notes, inputs, cycles
/// and binding_bound of the result are filled.
SimulationResult simulate_in_child(const std::string& trace_path, const GpuConfig& config,
                                   const SimulationOptions& options);

}  // namespace grtx::sim
