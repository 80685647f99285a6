// The statistics of a run in which one event in so many took time, as those of all events.
#pragma once

#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/rtl_tlm/run/lower_bounds.h"

namespace grtx::sim {

/// list: as counted. Counts and cycles are multiplied by the stride but for those of events, which are exact; times
/// that span several events of a lane are, too; ratios, other mean times and maxima stay.
modules::StatisticList of_all_events(const modules::StatisticList& list, unsigned stride);
/// The same of what follows from the work that took time; a ray's and a warp's own chain are exact.
std::vector<LowerBound> of_all_events(std::vector<LowerBound> bounds, unsigned stride);

}  // namespace grtx::sim
