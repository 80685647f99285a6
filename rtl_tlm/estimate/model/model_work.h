// The work of a trace's warps on a given cache, from its counts.
#pragma once

#include <vector>

#include "grtx/rtl_tlm/estimate/model/trace_counts.h"
#include "grtx/rtl_tlm/estimate/sampled/group_work.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

/// Share of a round's visits whose stack distance is below so many nodes; within a class distances are even on the
/// scale of logarithms.
double hits_within(const RoundCounts& round, double nodes);

/// Of every group. A warp has its share of the L1 among the calls of its SM, and of the L2 among those of all.
std::vector<GroupWork> work_of(const TraceCounts& counts, const traces::Header& header, const GpuConfig& config);

}  // namespace grtx::sim
