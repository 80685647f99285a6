// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/simulate_mode.h"

#include <fmt/format.h>

#include "grtx/base/long_work.h"

namespace grtx::experiment {

sim::EstimatedResult simulate_in_mode(sim::SimulationMode mode, const std::string& trace, const sim::GpuConfig& config,
                                      const sim::SimulationOptions& simulation, const sim::WindowOptions& windows) {
  if (mode == sim::SimulationMode::windows) return sim::simulate_windows(trace, config, windows);
  sim::EstimatedResult exact;
  exact.result = sim::simulate(trace, config, simulation);
  exact.estimate.whole = true;
  return exact;
}

void say_simulation_time(const std::string& command, sim::SimulationMode mode, std::uint64_t visits, double share,
                         std::uint64_t bytes, unsigned jobs) {
  constexpr double kCycle = 3.3e5;  // node visits a second of one core, as measured (kManyVisits)
  const double work = static_cast<double>(visits) * (mode == sim::SimulationMode::windows ? share : 1.0) / jobs;
  say_long_work(command, fmt::format("simulating {:.3g} M node visits", 1e-6 * static_cast<double>(visits)),
                work / kCycle, bytes,
                mode == sim::SimulationMode::cycle ? "of a whole frame --mode windows is faster" : "");
}

}  // namespace grtx::experiment
