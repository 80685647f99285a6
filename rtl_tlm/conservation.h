// Conservation laws of a run: every event of the trace executed exactly once, every request answered, nothing left.
#pragma once

#include <string>
#include <vector>

#include "rtl_tlm/gpu_counters.h"
#include "rtl_tlm/lower_bounds.h"
#include "traces/header.h"

namespace grtx::tlm {

/// One line for each law that does not hold; empty in a correct run. totals: of the groups that ran. groups: how many.
std::vector<std::string> conservation_violations(const GpuCounters& counters, const traces::Totals& totals,
                                                 std::uint64_t groups, const Gpu& gpu, const modules::Dram& dram,
                                                 const std::vector<LowerBound>& bounds);

}  // namespace grtx::tlm
