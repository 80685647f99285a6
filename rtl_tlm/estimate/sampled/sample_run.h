// One simulated sample: some groups of a trace on a scaled machine, in a process of its own.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/base/child_process.h"
#include "grtx/rtl_tlm/estimate/sampled/scaled_machine.h"
#include "grtx/rtl_tlm/estimate/simulation_mode.h"

namespace grtx::sim {

struct SampleRun {
  std::vector<std::uint64_t> groups;  ///< ascending
  ScaledMachine machine;
  double cycles = 0.0;
  std::vector<double> group_end;  ///< by position in groups
  nlohmann::ordered_json stats;   ///< of the run, by name
  std::vector<std::string> violations;
};

/// Starts the simulation.
std::unique_ptr<ChildProcess> start_sample(const std::string& trace_path, const SampleRun& run, SimulationMode engine);
/// Waits for its end and fills in what it gave.
void finish_sample(ChildProcess& child, SampleRun& run);

}  // namespace grtx::sim
