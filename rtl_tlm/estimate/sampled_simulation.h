// Sampled mode: the machine of cycle mode, in which one of each lane's events in sample.stride takes time. The others are
// executed at once by the same units.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/rtl_tlm/estimate/sampled_result.h"

namespace grtx::sim {

/// With fewer node visits one long ray decides a run's length, and a run takes seconds anyhow: all events take time.
inline constexpr std::uint64_t kFewestSampledVisits = 3'000'000;

/// What strides leave over in a run of any size (docs/model/sampled-mode.md).
ModelBias stride_bias(unsigned stride);

/// Cycles of a run of that stride and what they are worth. misses: by SM.
SampledEstimate estimate_from_stride(Cycle cycles, unsigned stride, const std::vector<modules::TimedMisses>& misses);

/// Simulates the trace with the stride that the keys name. target_error: relative half-width of the interval on cycles
/// to reach, by smaller strides; 0: none. A trace with few visits is simulated in cycle mode, and a note says so.
/// Without a target the run is in this process, as simulate() is; with one each is in a child. Throws what simulate()
/// throws.
SampledResult simulate_sampled(const std::string& trace_path, const GpuConfig& config,
                               const SimulationOptions& options, double target_error = 0.0);

}  // namespace grtx::sim
