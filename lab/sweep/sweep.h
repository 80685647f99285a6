// Runs what a sweep's database does not hold yet.
#pragma once

#include <cstdint>
#include <set>
#include <string>

#include "grtx/lab/sweep/database.h"
#include "grtx/lab/sweep/launcher.h"

namespace grtx::sim {

struct SweepSetting {
  std::string program;  ///< runs the tasks' commands
  std::string traces;   ///< folder of the traces, absolute
  std::string machine;  ///< NamedMachine::option of all points
  PlanLimits limits;
  bool quiet = false;
  std::string what = "sweep";  ///< for the progress
};

/// What making traces took.
struct TraceWork {
  std::uint64_t made = 0;
  std::uint64_t structures_built = 0;
  void add(const TraceWork& other) {
    made += other.made;
    structures_built += other.structures_built;
  }
};

/// Makes the traces that pending points need, or looks whether their files are sound, and runs the points; every
/// outcome is recorded as it comes. Points whose trace failed fail with its reason. sound_traces: keys of traces that
/// need no look; grows.
TraceWork run_points(const SweepPoints& all, SweepDatabase& database, Launcher& launcher, const WorkFolder& work,
                     const SweepSetting& setting, std::set<std::string>& sound_traces);

/// The finished points that no other of the same scene and view beats in both gpu.time_us and cost.mm2, in
/// the order given.
std::vector<SweepPoint> pareto_front(const std::vector<SweepPoint>& points, SweepDatabase& database);

}  // namespace grtx::sim
