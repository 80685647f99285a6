#include "grtx/rtl_tlm/run/run_report.h"

#include "grtx/rtl_tlm/run/conservation.h"
#include "grtx/rtl_tlm/run/lower_bounds.h"

namespace grtx::sim {

void report_run(const FinishedRun& finished, const MeasuredSource& source, const GpuConfig& config,
                const Engine* engine, const EnergyPricing& price, SimulationResult& result) {
  const GpuCounters& counters = finished.counters;
  const std::vector<LowerBound> bounds = lower_bounds(counters, source.longest(), config);
  result.cycles = counters.cycles;
  result.binding_bound = binding_bound(bounds).name;
  result.violations = count_violations(counters, source.totals(), source.count());
  if (engine != nullptr) result.caution = engine->caution();
  std::vector<std::string> below = bound_violations(counters.cycles, bounds);
  if (engine != nullptr && engine->estimates() && !below.empty()) {
    result.caution += (result.caution.empty() ? "" : ", ") + below.front();
    below.clear();
  }
  for (const auto& more : {finished.violations, below}) {
    result.violations.insert(result.violations.end(), more.begin(), more.end());
  }
  describe(counters, result.statistics);
  if (engine != nullptr) engine->describe(result.statistics);
  describe(bounds, counters.cycles, result.statistics);
  if (price) price(config, finished.inventories, source.totals().rays, result.statistics);
}

}  // namespace grtx::sim
