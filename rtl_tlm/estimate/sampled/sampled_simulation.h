// Sampled mode: simulates a share of a trace's groups on scaled machines and estimates the whole run.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "grtx/base/named_enum.h"
#include "grtx/rtl_tlm/estimate/sampled/estimate.h"
#include "grtx/rtl_tlm/estimate/simulation_mode.h"

namespace grtx::sim {

/// What the estimate of the whole run is made with.
enum class SampleModel : std::uint8_t {
  visits,  ///< fast mode of the whole trace, corrected by samples; `calls` where it lacks what is configured
  calls,   ///< the warp model, fitted to samples: faster, less exact
  windows  ///< windows of a large trace, and regression on what every group costs; `visits` for smaller ones
};
constexpr auto enum_names(SampleModel) {
  using enum SampleModel;
  return std::to_array<EnumName<SampleModel>>({{visits, "visits"}, {calls, "calls"}, {windows, "windows"}});
}

/// Of the groups.
double default_share(SampleModel model);

struct SampledOptions {
  std::optional<double> share;  ///< of the groups, to begin with, above 1/2 the whole trace; none: default_share(model)
  double target_error = 0.0;    ///< relative half-width of the interval on cycles to reach; 0: none
  std::uint64_t seed = 1;
  SampleModel model = SampleModel::visits;
  SimulationMode engine = SimulationMode::cycle;  ///< that simulates the samples
  unsigned jobs = 1;                              ///< simulations at a time, each a process of its own
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

/// Every simulation runs in a ChildProcess: may be called more than once a process. Throws what simulate() throws.
SampledResult simulate_sampled(const std::string& trace_path, const GpuConfig& config, const SampledOptions& options);

}  // namespace grtx::sim
