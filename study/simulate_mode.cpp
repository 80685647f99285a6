// SPDX-License-Identifier: Apache-2.0
#include "grtx/study/simulate_mode.h"

namespace grtx::study {

sim::SampledResult simulate_in_mode(sim::SimulationMode mode, const std::string& trace, const sim::GpuConfig& config,
                                    const sim::SimulationOptions& simulation, const sim::WindowOptions& windows) {
  if (mode == sim::SimulationMode::windows) return sim::simulate_windows(trace, config, windows);
  if (mode == sim::SimulationMode::sampled)
    return sim::simulate_sampled(trace, config, simulation, windows.target_error);
  sim::SampledResult exact;
  exact.result = sim::simulate(trace, config, simulation);
  exact.estimate.whole = true;
  return exact;
}

}  // namespace grtx::study
