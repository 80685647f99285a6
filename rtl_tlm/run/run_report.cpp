// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/run_report.h"

#include "grtx/rtl_tlm/run/conservation.h"
#include "grtx/rtl_tlm/run/lower_bounds.h"

namespace grtx::sim {

void report_run(const FinishedRun& finished, const MeasuredSource& source, const GpuConfig& config,
                const EnergyPricing& price, SimulationResult& result) {
  const GpuCounters& counters = finished.counters;
  result.bounds = lower_bounds(counters, source.longest(), config);
  const std::vector<LowerBound>& bounds = result.bounds;
  result.cycles = counters.cycles;
  result.binding_bound = binding_bound(bounds).name;
  result.violations = count_violations(counters, source.totals(), source.count());
  for (const auto& more : {finished.violations, bound_violations(result.cycles, bounds)}) {
    result.violations.insert(result.violations.end(), more.begin(), more.end());
  }
  describe(counters, result.statistics);
  describe(bounds, result.cycles, result.statistics);
  for (const modules::Statistic& s : finished.latency.items()) result.statistics.add(s);
  for (const GpuCounters& so_far : finished.at_launches) {
    modules::StatisticList& list = result.at_launches.emplace_back();
    describe(so_far, list);
    describe(lower_bounds(so_far, {}, config), so_far.cycles, list);
  }
  const auto add = [&result](ResultNotes more) { result.notes.insert(result.notes.end(), more.begin(), more.end()); };
  add(trace_notes(source.header(), source.totals()));
  add(run_notes(config, source.header(), source.count(), result.statistics));
  if (price) price(config, finished.inventories, source.totals().rays, result.statistics);
}

}  // namespace grtx::sim
