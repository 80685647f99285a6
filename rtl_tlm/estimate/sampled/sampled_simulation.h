// Sampled mode: simulates windows of a large trace, one after the other on the whole machine, and estimates the run.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/rtl_tlm/estimate/sampled/estimate.h"
#include "grtx/rtl_tlm/estimate/simulation_mode.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

struct SampledOptions {
  double share = 0.1;         ///< of the groups, to begin with, above 0; above 1/2 the whole trace
  double target_error = 0.0;  ///< relative half-width of the interval on cycles to reach; 0: none
  std::uint64_t seed = 1;
  SimulationMode engine = SimulationMode::cycle;  ///< that simulates the windows
  EnergyPricing price;                            ///< none: the estimate has no energy statistics
};

struct SampledResult {
  SimulationResult
      result;  ///< of the whole run, estimated; its document has gpu.sampled.*, and the estimate as "sampled"
  SampledEstimate estimate;
  ConfidenceInterval cycles;
};

/// Throws Error for options out of range.
void check_sampled(const SampledOptions& options);

/// Why windows of a trace do not stand for it on this machine; empty: they do.
std::string unsuited_to_windows(const traces::Reader& reader, const GpuConfig& config, const SampledOptions& options);

/// In cycle mode some five minutes of a core.
inline constexpr std::uint64_t kManyVisits = 100'000'000;
/// Whether a run that names no mode should take windows: they suit the trace, and it has at least `many` node visits.
bool windows_pay(const traces::Reader& reader, const GpuConfig& config, const SampledOptions& options,
                 std::uint64_t many = kManyVisits);

/// A trace that windows do not suit (too few groups, secondary rays) is simulated as a whole, in cycle mode, and a line
/// on stderr says so. Every simulation runs in a ChildProcess: may be called more than once a process. Throws what
/// simulate() throws, and Error for a sequence of frames.
SampledResult simulate_sampled(const std::string& trace_path, const GpuConfig& config, const SampledOptions& options);

}  // namespace grtx::sim
