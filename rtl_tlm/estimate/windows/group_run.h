// SPDX-License-Identifier: Apache-2.0
// Simulates some groups of a trace in a child process and records when each of them ran. Of the groups in between
// the caches get what they read, and all are counted.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "grtx/base/child_process.h"
#include "grtx/rtl_tlm/estimate/windows/group_work.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace grtx::sim {

/// Core cycles of the groups' launches and ends, by position in GroupRun::groups, which is the order of launches.
struct GroupTimes {
  std::vector<double> launched, ended;
};

struct GroupRun {
  std::vector<std::uint64_t> groups;   ///< indices in the trace, ascending
  std::vector<std::uint64_t> read_at;  ///< see SimulationOptions
  GroupTimes times;
  std::vector<GroupWork> work;  ///< by group of the trace, up to the last of `groups`
  double cycles = 0.0;
  modules::StatisticList statistics;
  std::vector<modules::StatisticList> at_launches;  ///< so far, when each of `read_at` was launched: names and numbers
  std::vector<LowerBound> bounds;
  std::vector<std::string> violations;
};

/// Starts the simulation of run.groups. `run` must outlive it.
std::unique_ptr<ChildProcess> start_group_run(const std::string& trace_path, const GpuConfig& config,
                                              const GroupRun& run);
/// Waits for its end and fills the rest of `run`.
void finish_group_run(ChildProcess& child, GroupRun& run);

}  // namespace grtx::sim
