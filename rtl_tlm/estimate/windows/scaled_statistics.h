// SPDX-License-Identifier: Apache-2.0
// The statistics of a whole run as estimated from its windows.
#pragma once

#include <nlohmann/json.hpp>

#include "grtx/modules/kernel/declare.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/run/ray_chain.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

/// Facts about the whole run that are known without simulating it, and its estimated cycles.
struct WholeRun {
  double cycles = 0.0;  ///< estimated
  std::uint64_t groups = 0;
  traces::Totals totals;
  Chain longest;
};

/// sample: statistics of the run of the windows. Counts are scaled by `factor` (work of the trace over work of the
/// windows), mean times and ratios are kept, maxima are those of the windows, counts known from the trace are exact.
/// Statistics of single SMs and channels are left out; WindowReport::add_energy() adds energy.
modules::StatisticList whole_statistics(const nlohmann::ordered_json& sample, double factor, const WholeRun& whole,
                                        const GpuConfig& config);

}  // namespace grtx::sim
