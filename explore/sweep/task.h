// SPDX-License-Identifier: Apache-2.0
// A task of a sweep (a trace or a point), described by a file so that any process on any node can run it: `grtx sweep
// --task F`.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "grtx/explore/sweep/plan.h"
#include "grtx/explore/sweep/points.h"

namespace grtx::explore {

struct Task {
  std::string key;  ///< key of the trace or point
  bool is_trace = false;
  nlohmann::ordered_json description;  ///< content of the description file
};

/// Tasks that one process runs in sequence: one point, or traces that share scene or structure.
using Job = std::vector<Task>;

/// Result of a task: status as in the database, the reason if not "done", and output. A point whose trace is damaged is
/// "pending" again.
struct TaskOutcome {
  std::string key;
  bool is_trace = false;
  std::string status;
  std::string reason;
  double seconds = 0.0;                           ///< wall time of simulation or tracer; 0 for an existing trace
  std::uint64_t bytes = 0;                        ///< size of a trace
  std::optional<std::uint64_t> structures_built;  ///< for a new trace only
  nlohmann::ordered_json document;                ///< statistics of a point, without host.*
  nlohmann::ordered_json cost;                    ///< grtx.cost/1 of a point
};

/// program: path of grtx. folder: absolute path of the traces' folder. limits: per command.
Task trace_task(const SweepTrace& trace, const std::string& program, const std::string& folder,
                const PlanLimits& limits);
Task point_task(const SweepPoint& point, const std::string& program, const std::string& folder,
                const PlanLimits& limits);

/// File name of a trace.
std::string trace_name(const std::string& key);

/// Runs the described tasks in sequence and writes the result of each atomically. Skips a trace whose file is undamaged
/// and made from the inputs of its key. Several traces share one process until one fails. scratch: MarkedFolder for
/// temporary files, created and removed here. Throws only if a description cannot be parsed or a result cannot be
/// written.
void run_tasks(const std::vector<std::string>& descriptions, const std::vector<std::string>& results,
               const std::string& scratch);

/// Reads a result of run_tasks(). Throws Error if it is damaged.
TaskOutcome read_outcome(const std::string& result);

}  // namespace grtx::explore
