// Fast mode on groups of a trace: when and where each of them ended.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/gpu_counters.h"
#include "grtx/rtl_tlm/run/first_launches.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

struct FastRun {
  GpuCounters counters;
  std::vector<Cycle> group_end;    ///< by position in `groups`
  std::vector<unsigned> group_sm;  ///< by position
  Cycle cycles() const { return counters.cycles; }
};

/// Groups of the trace, in launch order. known: SMs of the first ones, as seen. acquired(group) is called for each
/// group once, if it is not empty. Throws Error for a bad group and for what this mode does not model.
FastRun run_fast(const traces::Reader& reader, const std::vector<std::uint64_t>& groups,
                 const std::vector<Launch>& known, const GpuConfig& config,
                 const std::function<void(const traces::RayGroup&)>& acquired);

}  // namespace grtx::sim
