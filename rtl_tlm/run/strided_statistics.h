// SPDX-License-Identifier: Apache-2.0
// Scales the statistics of a sampled run, in which one event in `stride` took time, to all events.
#pragma once

#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/rtl_tlm/run/lower_bounds.h"

namespace grtx::sim {

/// list: as counted. Counts and cycles are multiplied by the stride, except counts of all events, which are exact. So
/// are times that span several events of a lane; ratios, other mean times and maxima are kept.
modules::StatisticList of_all_events(const modules::StatisticList& list, unsigned stride);
/// The same for bounds, which follow from timed work; those of the longest ray and warp are exact.
std::vector<LowerBound> of_all_events(std::vector<LowerBound> bounds, unsigned stride);

}  // namespace grtx::sim
