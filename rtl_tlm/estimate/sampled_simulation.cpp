// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/estimate/sampled_simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "grtx/base/error.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {
namespace {

/// Above so many lanes a fetch, strides merge too few lanes (docs/model/sampled-mode.md).
constexpr double kMostLanesAFetch = 1.6;

double lanes_a_fetch(const SampledResult& r) {
  return r.result.document.at("stats").at("gpu.rt.merge_factor").at("value").get<double>();
}

/// Why the trace is simulated in cycle mode whatever the stride; the id is empty if nothing speaks against sampling.
ResultNote why_whole(const std::string& trace_path, const GpuConfig& config) {
  if (config.rt.walks()) return {"merging", "cycle mode: the lanes of a warp share every fetch (rt.traversal = warp)"};
  const std::uint64_t visits = traces::Reader(trace_path).totals().visits();
  if (visits >= kFewestSampledVisits) return {};
  return {"small-view", fmt::format("cycle mode: {} node visits are too few to sample", visits)};
}

/// Adds estimate, interval, gpu.sampled.* and `notes` to the result of a run.
SampledResult finished(SimulationResult run, unsigned stride, const ResultNotes& notes) {
  SampledResult r;
  r.result = std::move(run);
  if (stride == 1) {
    make_whole(r);
  } else {
    r.estimate = estimate_from_stride(r.result.cycles, stride, r.result.sampled_work);
    r.cycles = cycles_interval(r.estimate);
  }
  r.result.inputs["mode"] = name_of(SimulationMode::sampled);
  for (const ResultNote& note : notes) {
    r.result.notes.push_back(note);
    r.result.document.at("notes").push_back({{"id", note.id}, {"text", note.text}});
  }
  modules::StatisticList list;
  list.add("gpu.sampled.stride", std::uint64_t{stride}, "events", "of each lane's events one in so many took time");
  describe_interval(r, list);
  for (const modules::Statistic& s : list.items()) r.result.statistics.add(s);
  add_to_document(list, r);
  return r;
}

constexpr std::uint64_t kInstructions = 1000;  ///< first number of the instruction subsamples; above any number of SMs

/// Adds the sampling errors of the SMs. weight: relative change of the cycles per relative change of the work.
void add_subsamples(const std::vector<modules::TimedShare>& shares, unsigned stride, double weight, std::uint64_t first,
                    SampledEstimate& estimate) {
  double all = 0.0;
  for (const modules::TimedShare& sm : shares) all += static_cast<double>(sm.all);
  for (std::size_t i = 0; i < shares.size(); ++i) {
    if (shares[i].all == 0) continue;
    const double off = static_cast<double>(shares[i].timed) * stride - static_cast<double>(shares[i].all);
    estimate.evidence.push_back({first + i, off / static_cast<double>(shares[i].all), weight * off / all});
  }
}

}  // namespace

ModelBias stride_bias(unsigned stride) {
  // Root mean square errors on generated scenes (docs/model/sampled-mode.md). Strides below 4 were not measured and are
  // taken to be no better; beyond 8 the errors are assumed to grow in proportion.
  constexpr ModelBias kAtFour{0.017, 0.020, 5.0}, kAtEight{0.022, 0.034, 5.0};
  if (stride <= 4) return kAtFour;
  const double growth = std::max(1.0, stride / 8.0);
  return {kAtEight.cycles * growth, kAtEight.ratio * growth, kAtEight.degrees};
}

SampledEstimate estimate_from_stride(Cycle cycles, unsigned stride, const SampledWork& work) {
  SampledEstimate estimate;
  estimate.log_cycles = std::log(static_cast<double>(cycles));
  estimate.bias = stride_bias(stride);
  add_subsamples(work.misses, stride, 1.0, 0, estimate);
  estimate.degrees_of_freedom = std::max<double>(1.0, static_cast<double>(estimate.evidence.size()));
  add_subsamples(work.instructions, stride, work.issue_share, kInstructions, estimate);
  return estimate;
}

SampledResult simulate_sampled(const std::string& trace_path, const GpuConfig& config, const SimulationOptions& options,
                               double target_error) {
  if (!(target_error >= 0.0 && target_error < 1.0)) {
    throw Error("sampled mode", "--target-error", "must be above 0 and below 100%");
  }
  check_mode(config, SimulationMode::sampled);
  check_config(config, "configuration");
  GpuConfig own = config;
  unsigned stride = config.sample.stride;
  ResultNotes notes;
  if (const ResultNote note = why_whole(trace_path, config); stride > 1 && !note.id.empty()) {
    stride = 1;
    notes.push_back(note);
  }
  const auto run = [&](auto&& simulation) {
    own.sampling = {stride, stride == 1 ? 0 : std::min(config.sample.offset, stride - 1)};
    return finished(simulation(trace_path, own, options), stride, notes);
  };
  // A process can simulate once, and more than one run may be needed: sampled runs are child processes.
  const bool any = target_error == 0.0;
  for (;; stride /= 2) {
    // Skips strides whose bias alone exceeds the target.
    SampledEstimate least;
    least.bias = stride_bias(stride);
    if (stride > 1 && !any && cycles_interval(least).half_width > target_error) continue;
    if (stride == 1) return run(simulate);
    SampledResult r = run(simulate_in_child);
    if (lanes_a_fetch(r) > kMostLanesAFetch) {
      notes.push_back(
          {"merging", fmt::format("cycle mode: {:.1f} lanes a fetch are too many to sample", lanes_a_fetch(r))});
      stride = 1;
      return run(simulate);
    }
    if (any || r.cycles.half_width <= target_error) return r;
  }
}

}  // namespace grtx::sim
