// SPDX-License-Identifier: Apache-2.0
// Windows mode: simulates stretches of a large trace back to back on the whole machine and estimates the run from them.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/rtl_tlm/estimate/estimated_result.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

struct WindowOptions {
  double share = 0.1;  ///< initial share of the groups, above 0, if it is kFewestWindows; above 1/2 all are simulated
  double target_error = 0.0;  ///< relative half-width of the interval on cycles to reach; 0: none
  std::uint64_t seed = 1;
  EnergyPricing price;  ///< empty: no energy statistics
};

/// Throws Error for options out of range.
void check_windows(const WindowOptions& options);

/// Why windows cannot represent the trace on this machine; empty: they can.
std::string unsuited_to_windows(const traces::Reader& reader, const GpuConfig& config, const WindowOptions& options);

/// Node visits that take about five minutes of one core in cycle mode.
inline constexpr std::uint64_t kManyVisits = 100'000'000;
/// Whether a run that names no mode should take windows: they suit the trace, and it has at least `many` node visits.
bool windows_pay(const traces::Reader& reader, const GpuConfig& config, const WindowOptions& options,
                 std::uint64_t many = kManyVisits);

/// A trace that windows do not suit (too few groups, secondary rays) is simulated completely in cycle mode, and a line
/// on stderr says so. Every simulation runs in a ChildProcess, so this may be called repeatedly. Throws what simulate()
/// throws, and Error for bad options, a sequence of frames, a unit in RTL, or a DRAM model other than built_in.
EstimatedResult simulate_windows(const std::string& trace_path, const GpuConfig& config, const WindowOptions& options);

}  // namespace grtx::sim
