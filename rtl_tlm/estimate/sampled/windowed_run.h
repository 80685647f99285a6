// Sampled mode of large traces: a thinned run, of windows of the trace.
#pragma once

#include "grtx/rtl_tlm/estimate/sampled/sampled_simulation.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

/// Whether the trace is one launch (one frame, no secondary rays) with groups enough for windows of that share, which
/// is given.
bool windows_fit(const traces::Reader& reader, const GpuConfig& config, const SampledOptions& options);

/// Needs windows_fit(). options.engine runs the windows. Throws what simulate() throws.
SampledResult simulate_windows(const traces::Reader& reader, const GpuConfig& config, const SampledOptions& options);

}  // namespace grtx::sim
