// The outline model: a run of a trace at the grain of node visits. It makes the decisions of the cycle model (which SM,
// which warp buffer entry, what hits in which cache, what is prefetched, checkpointed, blended), but a visit is one
// event and what the machine's parts do in between are reservations of ports. Some six to eight times as fast as cycle
// mode; how far it is off is measured on samples.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "rtl_tlm/first_launches.h"
#include "rtl_tlm/gpu_config.h"
#include "traces/io.h"

namespace grtx::tlm {

struct OutlineRun {
  Cycle cycles = 0;
  std::vector<Cycle> group_end;    ///< by position in `groups`
  std::vector<unsigned> group_sm;  ///< by position
  // Sectors.
  std::uint64_t l1_reads = 0, l1_hits = 0, l2_accesses = 0, dram = 0;
};

/// Groups of the trace, in launch order. known: SMs of the first ones, as seen. decoded(group) is called for each group
/// once. Throws Error for a bad group.
OutlineRun run_outline(const traces::Reader& reader, const std::vector<std::uint64_t>& groups,
                       const std::vector<Launch>& known, const GpuConfig& config,
                       const std::function<void(const traces::RayGroup&)>& decoded);

}  // namespace grtx::tlm
