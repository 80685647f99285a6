#include "grtx/rtl_tlm/estimate/simulation_mode.h"

#include <stdexcept>

#include "grtx/rtl_tlm/estimate/fast/fast_engine.h"

namespace grtx::sim {

SimulationResult simulate(const std::string& trace_path, const GpuConfig& config, const SimulationOptions& options,
                          SimulationMode mode) {
  if (mode == SimulationMode::cycle) return simulate(trace_path, config, options);
  if (mode == SimulationMode::sampled) throw std::logic_error("a sampled run is simulate_sampled()");
  FastEngine engine;
  return simulate(trace_path, config, options, engine);
}

}  // namespace grtx::sim
