// Model mode: the cycles of a configuration without simulating it, from the counts of the trace and fast runs of other
// warp buffers and cache sizes. For screening: milliseconds a configuration, in the order that cycle mode would give.
#pragma once

#include <string>

#include "grtx/rtl_tlm/run/simulation.h"

namespace grtx::sim {

/// Fast runs and counts that it needs and that are not kept beside the trace yet are made first; may be called more
/// than once a process. Throws what simulate() throws in fast mode. The document has gpu.model.* besides what
/// statistics_of_model() lists; no counts of single units.
SimulationResult simulate_model(const std::string& trace_path, const GpuConfig& config,
                                const SimulationOptions& options);

}  // namespace grtx::sim
