#include "grtx/study/simulate_mode.h"

namespace grtx::sim {

SampledResult simulate_in_mode(SimulationMode mode, const std::string& trace, const GpuConfig& config,
                               const SimulationOptions& simulation, const WindowOptions& windows) {
  if (mode == SimulationMode::windows) return simulate_windows(trace, config, windows);
  if (mode == SimulationMode::sampled) return simulate_sampled(trace, config, simulation, windows.target_error);
  SampledResult exact;
  exact.result = simulate(trace, config, simulation);
  exact.estimate.whole = true;
  return exact;
}

}  // namespace grtx::sim
