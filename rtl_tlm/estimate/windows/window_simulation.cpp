// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/estimate/windows/window_simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "grtx/rtl_tlm/estimate/windows/group_run.h"
#include "grtx/rtl_tlm/estimate/windows/scaled_statistics.h"
#include "grtx/rtl_tlm/estimate/windows/window_estimate.h"
#include "grtx/rtl_tlm/estimate/windows/window_plan.h"
#include "grtx/rtl_tlm/estimate/windows/window_report.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"
#include "grtx/rtl_tlm/run/ray_chain.h"
#include "grtx/rtl_tlm/run/trace_source.h"

namespace grtx::sim {
namespace {

constexpr std::uint64_t kCountedGroups = 8192;  ///< groups outside the windows whose costs are counted, approximately

constexpr const char* kSequence = "a sequence of frames needs cycle mode: windows would start a frame cold";

std::uint64_t slots_of(const GpuConfig& config) { return std::uint64_t{config.sms} * config.resident(); }

class WindowedRun {
 public:
  WindowedRun(const traces::Reader& reader, const GpuConfig& config, const WindowOptions& options)
      : reader_(reader),
        config_(config),
        options_(options),
        report_(reader, config, options_),
        counter_(reader.header(), config),
        latencies_(config, reader.header()) {
    reader.verify_content();
    if (!reader.header().frame_groups.empty()) throw Error(reader.path(), "", kSequence);
  }

  EstimatedResult run() {
    if (options_.share > kWholeTraceShare) return report_.whole("as asked for");
    if (const std::string why = unsuited_to_windows(reader_, config_, options_); !why.empty()) {
      return report_.whole(why);
    }
    if (options_.target_error > 0.0 && options_.target_error < least_half_width()) {
      return report_.whole("to reach --target-error, which is below what windows leave over");
    }
    for (double share = options_.share;; share *= 2.0) {
      simulate(share);
      const CycleEstimate estimate = evaluate();
      const ConfidenceInterval interval = cycles_interval(estimate);
      if (options_.target_error == 0.0 || interval.half_width <= options_.target_error) {
        return finished(estimate, interval);
      }
      if (2.0 * share > kWholeTraceShare) return report_.whole("to reach --target-error");
    }
  }

 private:
  /// Half-width of an interval whose only error is the bias.
  double least_half_width() const {
    CycleEstimate estimate;
    estimate.bias = kWindowsBias;
    return cycles_interval(estimate).half_width;
  }

  /// Counts the costs of the windows' groups and of every n-th other group, whose costs stand for those up to the next.
  void count_costs() {
    const std::uint64_t groups = reader_.group_count(), stride = std::max<std::uint64_t>(1, groups / kCountedGroups);
    costs_.resize(groups);
    counted_.resize(groups);
    for (std::uint64_t index = 0; index < groups; index += stride) count(index);
    for (const std::uint64_t index : sample_.groups) count(index);
    for (std::uint64_t index = 0; index < groups; ++index) {
      if (!counted_[index]) costs_[index] = costs_[index - index % stride];
    }
  }

  void count(std::uint64_t index) {
    if (counted_[index]) return;
    reader_.read(index, group_);
    check_group(group_, reader_.header(), reader_.path());
    costs_[index] = GroupCosts(counter_.count(group_));
    const Chain chain = measure_chain(group_, latencies_);
    longest_.ray = std::max(longest_.ray, chain.ray);
    longest_.warp = std::max(longest_.warp, chain.warp);
    counted_[index] = true;
  }

  void simulate(double share) {
    windows_ = plan_windows(reader_.group_count(), slots_of(config_), share, options_.seed);
    sample_ = {};
    sample_.groups = groups_of(windows_);
    sample_.read_at = launches_to_read(windows_);
    const std::unique_ptr<ChildProcess> child = start_group_run(reader_.path(), config_, sample_);
    count_costs();
    finish_group_run(*child, sample_);
  }

  CycleEstimate evaluate() {
    window_estimate_ = estimate_windows(sample_.times, windows_, costs_);
    CycleEstimate estimate;
    estimate.log_cycles = std::log(window_estimate_.cycles);
    estimate.degrees_of_freedom = window_estimate_.degrees_of_freedom;
    estimate.evidence = window_estimate_.evidence;
    estimate.bias = kWindowsBias;
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
    if (std::all_of(counted_.begin(), counted_.end(), [](bool counted) { return counted; })) whole.longest = longest_;
    WholeStatistics estimated = whole_statistics(sample_, windows_, costs_, whole);
    report_.add_energy(estimated);
    r.result.statistics = std::move(estimated.list);
    r.result.binding_bound = estimated.binding_bound;
    r.intervals = std::move(estimated.intervals);
    r.result.violations = sample_.violations;
    r.result.notes = notes(r.result.statistics);
    report_.describe(r, {sample_.groups.size(), residual_}, "", r.result.statistics);
    modules::StatisticList& list = r.result.statistics;
    list.add("gpu.windows.count", std::uint64_t{windows_.size()}, "windows", "of consecutive groups");
    list.add("gpu.windows.sector", window_estimate_.rates[0], "cycles/sector", "fitted: a node sector");
    list.add("gpu.windows.far", window_estimate_.rates[1], "cycles/sector", "fitted: a sector beyond the L2");
    list.add("gpu.windows.step", window_estimate_.rates[2], "cycles", "fitted: a dependent step of a warp");
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
  WorkCounter counter_;
  ChainLatencies latencies_;
  traces::RayGroup group_;
  std::vector<GroupCosts> costs_;  ///< of every group of the trace
  std::vector<bool> counted_;      ///< by group: its own costs were counted
  Chain longest_;
  std::vector<Window> windows_;
  GroupRun sample_;
  WindowEstimate window_estimate_;
  double residual_ = 0.0;
};

}  // namespace

std::string unsuited_to_windows(const traces::Reader& reader, const GpuConfig& config, const WindowOptions& options) {
  const std::uint64_t groups = reader.group_count();
  if (plan_windows(groups, slots_of(config), options.share, options.seed).empty()) {
    return fmt::format("{} warps are too few for {} windows at a share of {}", groups, kFewestWindows, options.share);
  }
  traces::RayGroup last;  // secondary rays are a second launch, after all primary ones
  reader.read(groups - 1, last);
  return last.kind == traces::RayKind::primary ? "" : "secondary rays are a second launch";
}

bool windows_pay(const traces::Reader& reader, const GpuConfig& config, const WindowOptions& options,
                 std::uint64_t many) {
  return reader.totals().visits() >= many && reader.header().frame_groups.empty() &&
         !unmodelled(config, SimulationMode::windows) && unsuited_to_windows(reader, config, options).empty();
}

void check_windows(const WindowOptions& options) {
  if (!(options.share > 0.0 && options.share <= 1.0)) {
    throw Error("windows mode", "--share", "must be above 0 and at most 1");
  }
  if (!(options.target_error >= 0.0 && options.target_error < 1.0)) {
    throw Error("windows mode", "--target-error", "must be above 0 and below 100%");
  }
}

EstimatedResult simulate_windows(const std::string& trace_path, const GpuConfig& config, const WindowOptions& options) {
  check_windows(options);
  check_config(config, "configuration");
  check_mode(config, SimulationMode::windows);
  const traces::Reader reader(trace_path);
  return WindowedRun(reader, config, options).run();
}

}  // namespace grtx::sim
