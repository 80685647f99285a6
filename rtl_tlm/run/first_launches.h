// The first launches of a run. Which SM gets which group decides how unequal the SMs' work is, and with it when the run
// ends: most warps meet little and make room for others within a few thousand cycles, in an order that a model which is
// off by a few cycles does not find. So those cycles are simulated in cycle mode, on the whole machine.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

/// Where and when a group was launched.
struct Launch {
  unsigned sm = 0;
  Cycle cycle = 0;
};

/// Launches by position in `groups` (those of the trace that run), as far as they come in the first 6000 core cycles.
/// Runs in a child process.
std::vector<Launch> first_launches(const traces::Reader& reader, const std::vector<std::uint64_t>& groups,
                                   const GpuConfig& config);

}  // namespace grtx::sim
