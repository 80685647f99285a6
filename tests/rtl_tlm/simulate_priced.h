// simulate() as the program calls it: with the energy of the run.
#pragma once

#include <string>
#include <utility>

#include "grtx/explore/cost/energy_statistics.h"
#include "grtx/rtl_tlm/estimate/simulation_mode.h"

namespace grtx::sim::test {

inline SimulationResult simulate_priced(const std::string& trace, const GpuConfig& config,
                                        SimulationOptions options = {}, SimulationMode mode = SimulationMode::cycle) {
  options.price = describe_energy;
  return simulate(trace, config, options, mode);
}

}  // namespace grtx::sim::test
