// The statistics of a whole run as estimated from samples.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "grtx/modules/kernel/statistics.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/run/ray_chain.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

/// What is known of the whole run beyond the samples.
struct WholeRun {
  double cycles = 0.0;         ///< estimated
  double busiest_share = 0.0;  ///< of all work, of the SM with most of it; from the warp model
  std::uint64_t groups = 0;
  traces::Totals totals;
  Chain longest;
};

/// `sample`: statistics of runs on half SMs, whose contention is that of the whole run. Counts are scaled by `factor`
/// (work of the trace over work of the samples), times and ratios stay, maxima are those of the samples, counts that
/// the trace itself gives are exact. Statistics of single SMs and channels are left out; energy is not in the list yet.
modules::StatisticList whole_statistics(const std::vector<const nlohmann::ordered_json*>& sample, double factor,
                                        const WholeRun& whole, const GpuConfig& config);

}  // namespace grtx::sim
