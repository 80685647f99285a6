// Configuration keys that are set and have no effect.
#pragma once

#include <string>
#include <vector>

#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"

namespace grtx::sim {

/// A key that the mode or another key leaves without effect.
struct IdleKey {
  std::string key;
  std::string because;  ///< "dram.scheduling = fcfs", "--mode cycle"
};
/// All that have another value than their default, in order of the keys.
std::vector<IdleKey> idle_keys(const GpuConfig& config, SimulationMode mode);

/// Lines on stderr that name them, if there are any.
void warn_of_idle_keys(const GpuConfig& config, SimulationMode mode);

}  // namespace grtx::sim
