// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/run_report.h"

#include <algorithm>

#include "grtx/rtl_tlm/run/conservation.h"
#include "grtx/rtl_tlm/run/lower_bounds.h"
#include "grtx/rtl_tlm/run/strided_statistics.h"

namespace grtx::sim {
namespace {

SampledWork sampled_work(const GpuCounters& counters, const GpuConfig& config) {
  const double slots = static_cast<double>(counters.cycles) * config.sms * config.simt.schedulers;
  return {counters.timed_misses, counters.timed_instructions,
          slots == 0.0 ? 0.0 : std::min(1.0, static_cast<double>(counters.simt.all_instructions()) / slots)};
}

}  // namespace

void report_run(const FinishedRun& finished, const MeasuredSource& source, const GpuConfig& config,
                const EnergyPricing& price, SimulationResult& result) {
  const GpuCounters& counters = finished.counters;
  const unsigned stride = config.sampling.stride;
  const std::vector<LowerBound> bounds = of_all_events(lower_bounds(counters, source.longest(), config), stride);
  result.cycles = counters.cycles * stride;
  result.binding_bound = binding_bound(bounds).name;
  result.violations = count_violations(counters, source.totals(), source.count(), stride > 1);
  std::vector<std::string> below = bound_violations(result.cycles, bounds);
  if (config.sampling.on() && !below.empty()) {
    result.notes.push_back({"below-bound", "the estimate breaks a lower bound: " + below.front()});
    below.clear();
  }
  for (const auto& more : {finished.violations, below}) {
    result.violations.insert(result.violations.end(), more.begin(), more.end());
  }
  if (config.sampling.on()) result.sampled_work = sampled_work(counters, config);
  describe(counters, result.statistics);
  if (config.sampling.on()) result.statistics = of_all_events(result.statistics, stride);
  describe(bounds, result.cycles, result.statistics);
  const auto add = [&result](ResultNotes more) { result.notes.insert(result.notes.end(), more.begin(), more.end()); };
  add(trace_notes(source.header(), source.totals()));
  add(run_notes(config, source.header(), source.count(), result.statistics));
  if (price) price(config, finished.inventories, source.totals().rays, result.statistics);
}

}  // namespace grtx::sim
