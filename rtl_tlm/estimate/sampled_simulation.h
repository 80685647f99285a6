// SPDX-License-Identifier: Apache-2.0
// Sampled mode: the machine of cycle mode, but only one in sample.stride events of each lane takes time. The same units
// execute the other events functionally, in zero time.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/rtl_tlm/estimate/sampled_result.h"

namespace grtx::sim {

/// Traces with fewer node visits run in cycle mode: one long ray would decide their length, and they take only seconds.
inline constexpr std::uint64_t kFewestSampledVisits = 3'000'000;

/// Bias of sampled mode with this stride, however long the run (docs/model/sampled-mode.md).
ModelBias stride_bias(unsigned stride);

/// Estimate from a sampled run. cycles: already multiplied by the stride. work: all and timed misses and
/// instructions of each SM. What they are apart is the sampling error; instructions are weighted by how much the issue
/// slots limit the run.
SampledEstimate estimate_from_stride(Cycle cycles, unsigned stride, const SampledWork& work);

/// Simulates the trace with sample.stride. target_error: relative half-width of the interval on cycles, reached by
/// halving the stride; 0: none. A trace with few visits, or with many lanes a fetch, runs in cycle mode, and a note
/// says so. A sampled run is a child process, whose result has its document and no lists of statistics; cycle mode runs
/// in this process, like simulate(). Throws what simulate() throws, and Error for a target out of range or a unit in
/// RTL.
SampledResult simulate_sampled(const std::string& trace_path, const GpuConfig& config, const SimulationOptions& options,
                               double target_error = 0.0);

}  // namespace grtx::sim
