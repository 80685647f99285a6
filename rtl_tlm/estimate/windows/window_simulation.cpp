// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "grtx/base/child_process.h"
#include "grtx/rtl_tlm/estimate/windows/group_run.h"
#include "grtx/rtl_tlm/estimate/windows/scaled_statistics.h"
#include "grtx/rtl_tlm/estimate/windows/window_estimate.h"
#include "grtx/rtl_tlm/estimate/windows/window_plan.h"
#include "grtx/rtl_tlm/estimate/windows/window_refusal.h"
#include "grtx/rtl_tlm/estimate/windows/window_report.h"

namespace grtx::sim {
namespace {

class WindowedRun {
 public:
  WindowedRun(const traces::Reader& reader, const GpuConfig& config, const WindowOptions& options)
      : reader_(reader), config_(config), options_(options), report_(reader, config, options_) {
    reader.verify_content();
    check_windows(reader);
  }

  EstimatedResult run() {
    if (const std::string why = reason_for_whole(reader_, config_, options_); !why.empty()) return report_.whole(why);
    for (double share = options_.share;;) {
      simulate(share);
      const CycleEstimate estimate = evaluate();
      const ConfidenceInterval interval = cycles_interval(estimate);
      if (options_.target_error == 0.0 || interval.half_width <= options_.target_error) {
        return finished(estimate, interval);
      }
      share = 2.0 *
              std::max(share, static_cast<double>(sample_.groups.size()) / static_cast<double>(reader_.group_count()));
      if (const std::string why = reason_for_whole(share); !why.empty()) return report_.whole(why);
    }
  }

 private:
  void simulate(double share) {
    windows_ = plan_windows(reader_.group_count(), window_slots(config_), share, options_.seed);
    sample_ = {};
    sample_.groups = groups_of(windows_);
    sample_.read_at = launches_to_read(windows_);
    const std::unique_ptr<ChildProcess> child = start_group_run(reader_.path(), config_, sample_);
    finish_group_run(*child, sample_);
    costs_ = std::vector<GroupCosts>(sample_.work.begin(), sample_.work.end());
  }

  CycleEstimate evaluate() {
    window_estimate_ = estimate_windows(sample_.times, windows_, costs_);
    CycleEstimate estimate;
    estimate.log_cycles = std::log(window_estimate_.cycles);
    estimate.drift = window_estimate_.drift;
    estimate.evidence = window_estimate_.evidence;
    double squares = 0.0;
    for (const GroupEvidence& e : estimate.evidence) squares += e.residual * e.residual;
    residual_ = std::sqrt(squares / static_cast<double>(estimate.evidence.size()));
    return estimate;
  }

  EstimatedResult finished(const CycleEstimate& estimate, const ConfidenceInterval& interval) const {
    EstimatedResult r;
    r.estimate = estimate;
    r.cycles = interval;
    r.result.cycles = static_cast<Cycle>(std::llround(interval.value));
    WholeRun whole;
    whole.cycles = interval;
    whole.groups = reader_.group_count();
    whole.totals = reader_.totals();
    WholeStatistics estimated = whole_statistics(sample_, windows_, costs_, whole);
    report_.add_energy(estimated);
    leave_out_misses(estimated);
    r.result.statistics = std::move(estimated.list);
    r.result.binding_bound = estimated.binding_bound;
    r.intervals = std::move(estimated.intervals);
    r.result.violations = sample_.violations;
    r.result.notes = notes(r.result.statistics);
    report_.describe(r, {sample_.groups.size(), residual_}, "", r.result.statistics);
    modules::StatisticList& list = r.result.statistics;
    list.add("gpu.windows.count", std::uint64_t{windows_.size()}, "windows", "of consecutive groups",
             modules::StatisticKind::count);
    list.add("gpu.windows.sector", window_estimate_.rates[0], "cycles/sector", "fitted: a node sector",
             modules::StatisticKind::state);
    list.add("gpu.windows.distinct", window_estimate_.rates[1], "cycles/sector", "fitted: a distinct sector of a warp",
             modules::StatisticKind::state);
    list.add("gpu.windows.step", window_estimate_.rates[2], "cycles", "fitted: an event of a warp's longest ray",
             modules::StatisticKind::state);
    report_.finish(r);
    return r;
  }

  ResultNotes notes(const modules::StatisticList& statistics) const {
    ResultNotes all = trace_notes(reader_.header(), reader_.totals());
    const ResultNotes more = run_notes(config_, reader_.header(), reader_.group_count(), statistics);
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  const traces::Reader& reader_;
  const GpuConfig& config_;
  WindowOptions options_;
  WindowReport report_;
  std::vector<GroupCosts> costs_;  ///< of every group of the trace
  std::vector<Window> windows_;
  GroupRun sample_;
  WindowEstimate window_estimate_;
  double residual_ = 0.0;
};

}  // namespace

EstimatedResult simulate_windows(const std::string& trace_path, const GpuConfig& config, const WindowOptions& options) {
  check_windows(options);
  check_config(config, "configuration");
  check_mode(config, SimulationMode::windows);
  const traces::Reader reader(trace_path);
  return WindowedRun(reader, config, options).run();
}

}  // namespace grtx::sim
