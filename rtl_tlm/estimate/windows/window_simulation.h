// Windows: simulates some stretches of a large trace, one after the other on the whole machine, and estimates the run.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/rtl_tlm/estimate/sampled_result.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

struct WindowOptions {
  double share = 0.1;         ///< of the groups, to begin with, above 0; above 1/2 the whole trace
  double target_error = 0.0;  ///< relative half-width of the interval on cycles to reach; 0: none
  std::uint64_t seed = 1;
  EnergyPricing price;  ///< none: the estimate has no energy statistics
};

/// What windows leave over, of four designs of a full frame (docs/results/windows.md).
inline constexpr ModelBias kWindowsBias{0.012, 0.02};

/// Throws Error for options out of range.
void check_windows(const WindowOptions& options);

/// Why windows of a trace do not stand for it on this machine; empty: they do.
std::string unsuited_to_windows(const traces::Reader& reader, const GpuConfig& config, const WindowOptions& options);

/// In cycle mode some five minutes of a core.
inline constexpr std::uint64_t kManyVisits = 100'000'000;
/// Whether a run that names no mode should take windows: they suit the trace, and it has at least `many` node visits.
bool windows_pay(const traces::Reader& reader, const GpuConfig& config, const WindowOptions& options,
                 std::uint64_t many = kManyVisits);

/// A trace that windows do not suit (too few groups, secondary rays) is simulated as a whole, in cycle mode, and a line
/// on stderr says so. Every simulation runs in a ChildProcess: may be called more than once a process. Throws what
/// simulate() throws, and Error for a sequence of frames.
SampledResult simulate_windows(const std::string& trace_path, const GpuConfig& config, const WindowOptions& options);

}  // namespace grtx::sim
