// One piece of a sweep's work, described in a file so that any process on any node can do it: `grtx sweep --task F`.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "grtx/lab/sweep/plan.h"
#include "grtx/lab/sweep/points.h"

namespace grtx::sim {

struct Task {
  std::string key;  ///< of the trace or the point
  bool is_trace = false;
  nlohmann::ordered_json description;  ///< what the file holds
};

/// Tasks of one process, one after the other. Several are traces that have much in common.
using Job = std::vector<Task>;

/// How a task ended: `status` of the database, the reason when it is not "done", and what it made. A point whose trace
/// is damaged is "pending" again.
struct TaskOutcome {
  std::string key;
  bool is_trace = false;
  std::string status;
  std::string reason;
  double seconds = 0.0;     ///< wall time of the simulation or the tracer; 0 for a trace that was there
  std::uint64_t bytes = 0;  ///< of a trace
  std::optional<std::uint64_t> structures_built;  ///< for a trace; none when it was there
  nlohmann::ordered_json document;                ///< statistics of a point, without host.*
  nlohmann::ordered_json cost;                    ///< grtx.cost/1 of a point
};

/// program: the grtx to run. folder: where the traces lie, absolute. limits: for each command. machine:
/// NamedMachine::option.
Task trace_task(const SweepTrace& trace, const std::string& program, const std::string& folder,
                const PlanLimits& limits);
Task point_task(const SweepPoint& point, const std::string& machine, const std::string& program,
                const std::string& folder, const PlanLimits& limits);

/// Name of a trace's file in the traces' folder.
std::string trace_name(const std::string& key);

/// Does what the files describe, one after the other, and writes for each its result, complete or not at all. A trace
/// whose file is there, sound, and made from the files and options that its key stands for is not made again; several
/// are made by one process, as long as all goes well. scratch: an OwnFolder for their files, made and removed. Throws
/// only when a description is none or a result cannot be written.
void run_tasks(const std::vector<std::string>& descriptions, const std::vector<std::string>& results,
               const std::string& scratch);

/// Reads a result of run_tasks(). Throws Error when it is damaged.
TaskOutcome read_outcome(const std::string& result);

}  // namespace grtx::sim
