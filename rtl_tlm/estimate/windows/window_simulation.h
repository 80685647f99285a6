// SPDX-License-Identifier: Apache-2.0
// Windows mode: simulates stretches of a large trace back to back on the whole machine and estimates the run from them.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/rtl_tlm/estimate/estimated_result.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

struct WindowOptions {
  double share = 0.25;  ///< initial share of the groups, at least kLeastOfTrace; above kMostOfTrace all are simulated
  double target_error = 0.0;  ///< relative half-width of the interval on cycles to reach; 0: none
  std::uint64_t seed = 1;
  EnergyPricing price;  ///< empty: no energy statistics
};

/// A trace that windows do not suit (too few groups, secondary rays) is simulated completely in cycle mode, and a line
/// on stderr says so. Every simulation runs in a ChildProcess, so this may be called repeatedly. Throws what simulate()
/// throws, and Error for what windows mode refuses (window_refusal.h).
EstimatedResult simulate_windows(const std::string& trace_path, const GpuConfig& config, const WindowOptions& options);

}  // namespace grtx::sim
