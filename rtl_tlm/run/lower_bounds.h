// SPDX-License-Identifier: Apache-2.0
// Lower bounds on a run's cycles: each resource alone, perfectly used. A run below one of them is wrong; the largest
// shows what limits the design.
#pragma once

#include <string>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/gpu_counters.h"
#include "grtx/rtl_tlm/run/ray_chain.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

struct LowerBound {
  std::string name;  ///< without the prefix gpu.bound.
  Cycle cycles = 0;
  std::string description;
  bool of_chain = false;  ///< of the trace's longest chain, not of a unit's work
};

/// Of its statistics: gpu.bound.NAME.
inline const std::string kBoundPrefix = "gpu.bound.";

/// Of the longest dependent chain of a trace.
std::vector<LowerBound> chain_bounds(const Chain& longest);
/// From the work that each SM and slice of this run did, and its longest chain.
std::vector<LowerBound> lower_bounds(const GpuCounters& counters, const Chain& longest, const GpuConfig& config);
/// The largest (the first of equals).
const LowerBound& binding_bound(const std::vector<LowerBound>& bounds);
/// gpu.bound.NAME for each, gpu.bound.largest and gpu.bound.fraction.
void describe(const std::vector<LowerBound>& bounds, Cycle cycles, modules::StatisticList& list);

}  // namespace grtx::sim
