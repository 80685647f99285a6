// SPDX-License-Identifier: Apache-2.0
// Conservation laws of a run: every event of the trace executed exactly once, every request answered, nothing left.
#pragma once

#include <string>
#include <vector>

#include "grtx/rtl_tlm/gpu/gpu_counters.h"
#include "grtx/rtl_tlm/run/lower_bounds.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

// Each returns one line for each law that does not hold; none in a correct run.

/// Work and requests. totals, groups: content and number of the groups that ran.
std::vector<std::string> count_violations(const GpuCounters& counters, const traces::Totals& totals,
                                          std::uint64_t groups);
/// Queues, MSHRs, warp slots and DRAM payloads at the end.
std::vector<std::string> emptiness_violations(const Gpu& gpu, const MemorySystem& memory);
/// No run is faster than a lower bound.
std::vector<std::string> bound_violations(Cycle cycles, const std::vector<LowerBound>& bounds);

}  // namespace grtx::sim
