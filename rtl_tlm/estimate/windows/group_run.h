// One run of some groups of a trace, in a process of its own: when each of them ran.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/base/child_process.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace grtx::sim {

/// By position in the groups that ran, core cycles. Launches come in that order.
struct GroupTimes {
  std::vector<double> launched, ended;
};

struct GroupRun {
  std::vector<std::uint64_t> groups;  ///< of the trace, ascending
  GroupTimes times;
  double cycles = 0.0;
  nlohmann::ordered_json stats;  ///< by name
  std::vector<std::string> violations;
};

/// Starts the simulation; `run` outlives it.
std::unique_ptr<ChildProcess> start_group_run(const std::string& trace_path, const GpuConfig& config,
                                              const GroupRun& run);
/// Waits for its end and fills in what it gave.
void finish_group_run(ChildProcess& child, GroupRun& run);

}  // namespace grtx::sim
