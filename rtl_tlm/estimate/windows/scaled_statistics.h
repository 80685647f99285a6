// SPDX-License-Identifier: Apache-2.0
// The statistics of a whole run as estimated from its windows, each by its kind: exact, with an interval, or absent.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/rtl_tlm/estimate/estimate.h"
#include "grtx/rtl_tlm/estimate/windows/group_run.h"
#include "grtx/rtl_tlm/estimate/windows/window_estimate.h"
#include "grtx/rtl_tlm/estimate/windows/window_plan.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

/// Places in groups_of(windows) at whose launches the counters of the run must be read (GroupRun::read_at): begin and
/// end of what is measured of each window.
std::vector<std::uint64_t> launches_to_read(const std::vector<Window>& windows);

/// Facts about the whole run that are known without simulating it, and its estimated cycles.
struct WholeRun {
  ConfidenceInterval cycles;
  std::uint64_t groups = 0;
  traces::Totals totals;
};

struct WholeStatistics {
  modules::StatisticList list;
  std::map<std::string, StatisticInterval> intervals;  ///< of all that are not exact
  std::string binding_bound;                           ///< name of the largest lower bound
};

/// run: of the windows. costs: by group of the trace. Totals of the trace are exact, traceRay calls among them. Of the
/// others, what happened up to the first measured launch and after the last launch happens once in the whole run, too;
/// the rest is scaled by node sectors. Means and ratios are made from counts that are scaled so. Intervals follow from
/// how the windows differ, as that of the cycles does. Left out are largest values, states, and statistics of single
/// SMs and channels; energy is added by WindowReport::add_energy().
WholeStatistics whole_statistics(const GroupRun& run, const std::vector<Window>& windows,
                                 const std::vector<GroupCosts>& costs, const WholeRun& whole);

/// Leaves out what counts misses of caches, or what follows from them in crossbar and DRAM: the windows' caches hold
/// about what those of the whole run hold, which is enough for cycles, not for these.
void leave_out_misses(WholeStatistics& statistics);

/// The list with the lower or the upper ends of its intervals in place of the values.
modules::StatisticList at_ends(const WholeStatistics& statistics, bool upper);

}  // namespace grtx::sim
