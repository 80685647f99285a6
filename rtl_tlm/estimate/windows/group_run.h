// SPDX-License-Identifier: Apache-2.0
// Simulates some groups of a trace in a child process and records when each of them ran.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/base/child_process.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace grtx::sim {

/// Core cycles of the groups' launches and ends, by position in GroupRun::groups, which is the order of launches.
struct GroupTimes {
  std::vector<double> launched, ended;
};

struct GroupRun {
  std::vector<std::uint64_t> groups;  ///< indices in the trace, ascending
  GroupTimes times;
  double cycles = 0.0;
  nlohmann::ordered_json stats;  ///< "stats" of the statistics document
  std::vector<std::string> violations;
};

/// Starts the simulation of run.groups. `run` must outlive it.
std::unique_ptr<ChildProcess> start_group_run(const std::string& trace_path, const GpuConfig& config,
                                              const GroupRun& run);
/// Waits for its end and fills times, cycles, stats and violations of `run`.
void finish_group_run(ChildProcess& child, GroupRun& run);

}  // namespace grtx::sim
