// SPDX-License-Identifier: Apache-2.0
// Runs the pending points of a sweep's database.
#pragma once

#include <cstdint>
#include <set>
#include <string>

#include "grtx/explore/sweep/database.h"
#include "grtx/explore/sweep/launcher.h"

namespace grtx::explore {

struct SweepSetting {
  std::string program;  ///< path of grtx that runs the tasks
  std::string traces;   ///< folder of the traces, absolute
  PlanLimits limits;
  bool quiet = false;
  std::string what = "sweep";  ///< label of the progress bar
};

/// Number of traces made and of acceleration structures built for them.
struct TraceWork {
  std::uint64_t made = 0;
  std::uint64_t structures_built = 0;
  void add(const TraceWork& other) {
    made += other.made;
    structures_built += other.structures_built;
  }
};

/// Makes or verifies the traces that pending points need, and runs the points. Records each outcome as it arrives.
/// Points whose trace failed fail with its reason. sound_traces: keys of verified traces; new ones are added.
TraceWork run_points(const SweepPoints& all, SweepDatabase& database, Launcher& launcher, const WorkFolder& work,
                     const SweepSetting& setting, std::set<std::string>& sound_traces);

/// The finished points on the Pareto front of gpu.time_us and the plan's area of their scene and view, in the given
/// order.
std::vector<SweepPoint> pareto_front(const std::vector<SweepPoint>& points, SweepDatabase& database,
                                     const std::string& area);

}  // namespace grtx::explore
