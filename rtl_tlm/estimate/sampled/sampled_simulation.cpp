#include "grtx/rtl_tlm/estimate/sampled/sampled_simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "grtx/rtl_tlm/estimate/fast/fast_run.h"
#include "grtx/rtl_tlm/estimate/sampled/fast_correction.h"
#include "grtx/rtl_tlm/estimate/sampled/group_run.h"
#include "grtx/rtl_tlm/estimate/sampled/model_fit.h"
#include "grtx/rtl_tlm/estimate/sampled/sampled_report.h"
#include "grtx/rtl_tlm/estimate/sampled/sampler.h"
#include "grtx/rtl_tlm/estimate/sampled/scaled_machine.h"
#include "grtx/rtl_tlm/estimate/sampled/scaled_statistics.h"
#include "grtx/rtl_tlm/estimate/sampled/windowed_run.h"
#include "grtx/rtl_tlm/gpu/mode_keys.h"
#include "grtx/rtl_tlm/run/lower_bounds.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

constexpr double kLargestPair = 1.0 / 16.0;  ///< share of the groups in one pair of samples
constexpr double kFewestWarps = 2.0;         ///< of equal work that a sample must hold to tell anything

/// Belief about the rates before a sample is seen.
RatePrior prior_of(const GpuConfig& config) {
  const ModelRates nominal = nominal_rates(config);
  return {{std::log(nominal.step_cycles), std::log(nominal.sm_sectors), std::log(nominal.sm_far),
           std::log(nominal.memory_sectors)},
          {0.7, 0.15, 0.4, 0.5}};
}

constexpr unsigned kFewestClasses = 4;  ///< a pair of samples is half of the trace then

/// What choosing and weighting need.
GroupWork brief_work(const traces::RayGroup& group) {
  GroupWork work;
  work.kind = group.kind;
  for (const traces::Ray& ray : group.rays) {
    work.sectors += static_cast<double>(ray.events.size());
    for (const traces::Round& round : ray.rounds) work.processed += round.processed_count;
  }
  return work;
}

/// Some groups on a scaled machine.
struct SampleRun : GroupRun {
  ScaledMachine machine;
};

class SampledRun {
 public:
  SampledRun(const std::string& trace_path, const GpuConfig& config, const SampledOptions& options)
      : path_(trace_path), config_(config), options_(options), reader_(trace_path), report_(reader_, config, options_) {
    reader_.verify_content();
    if (!reader_.header().frame_groups.empty()) {
      throw Error(reader_.path(), "", "a sequence of frames needs cycle or fast mode: samples share no caches");
    }
    if (const Unmodelled lack = unmodelled(config, SimulationMode::sampled)) {
      throw Error("configuration", std::string(lack.key), lack.rule);
    }
    if (unmodelled(config, SimulationMode::fast)) options_.model = SampleModel::calls;
  }

  SampledResult run() {
    if (*options_.share > kWholeFrom) return report_.whole("as asked for");
    if (visits()) {
      run_whole_fast();
    } else {
      work_ = measure_work(reader_, config_);
    }
    for (const GroupWork& group : work_.groups) {
      all_.push_back(&group);
      sectors_ += group.sectors;
      squares_ += group.sectors * group.sectors;
    }
    const double pair = std::min(*options_.share, kLargestPair);
    auto classes = static_cast<unsigned>(std::lround(2.0 / pair));
    const double warps = squares_ > 0.0 ? sectors_ * sectors_ / squares_ : 0.0;
    // Of small traces fast mode needs a larger share.
    if (visits()) classes = std::min(classes, static_cast<unsigned>(warps / kFewestWarps));
    if (classes < kFewestClasses || warps / classes < kFewestWarps) {
      return report_.whole(fmt::format("the trace is too small: its work is that of {:.0f} equal warps", warps));
    }
    classes_ = deal_classes(work_.groups, classes, options_.seed);
    std::size_t pairs = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(*options_.share / pair)));
    for (;;) {
      simulate_pairs(pairs);
      const SampledEstimate estimate = visits() ? correct() : evaluate();
      const ConfidenceInterval interval = cycles_interval(estimate);
      if (options_.target_error == 0.0 || interval.half_width <= options_.target_error) return finished(estimate);
      pairs *= 2;
      if (static_cast<double>(2 * pairs) / classes > kWholeFrom) return report_.whole("to reach --target-error");
    }
  }

 private:
  bool visits() const { return options_.model == SampleModel::visits; }
  /// Simulates until there are so many pairs of samples.
  void simulate_pairs(std::size_t pairs) {
    const std::size_t before = samples_.size();
    std::vector<std::pair<SampleRun*, std::unique_ptr<ChildProcess>>> running;
    const auto collect = [&] {
      finish_group_run(*running.front().second, *running.front().first);
      running.erase(running.begin());
    };
    for (std::size_t i = before; i < 2 * pairs; ++i) {
      auto sample = std::make_unique<SampleRun>();
      sample->groups = classes_[i];
      sample->engine = options_.engine;
      sample->machine = visits() || i % 2 != 0 ? idle_neighbours(config_) : half_sm(config_);
      samples_.push_back(std::move(sample));
    }
    if (known_.empty()) look_at_front();
    for (std::size_t i = before; i < samples_.size(); ++i) {
      if (running.size() >= options_.jobs) collect();
      running.emplace_back(samples_[i].get(), start_group_run(path_, samples_[i]->machine.config, *samples_[i]));
    }
    while (!running.empty()) collect();
  }

  void look_at_front() {
    std::vector<std::uint64_t> groups(reader_.group_count());
    std::iota(groups.begin(), groups.end(), std::uint64_t{0});
    known_ = first_launches(reader_, groups, config_);
  }

  /// Runs fast mode of the whole trace, and counts the groups' work on the way.
  void run_whole_fast() {
    look_at_front();
    const ChainLatencies latencies(config_, reader_.header());
    std::vector<std::uint64_t> groups(reader_.group_count());
    std::iota(groups.begin(), groups.end(), std::uint64_t{0});
    GpuConfig config = config_;
    config.fast.seed = options_.seed;
    whole_fast_ = run_fast(reader_, groups, known_, config, [&](const traces::RayGroup& group) {
      work_.groups.push_back(brief_work(group));
      const Chain chain = measure_chain(group, latencies);
      work_.longest.ray = std::max(work_.longest.ray, chain.ray);
      work_.longest.warp = std::max(work_.longest.warp, chain.warp);
    });
  }

  /// Fast mode's cycles, corrected by the samples in which the SM is not held up by others: with the DRAM of
  /// half an SM, the scaled machine is less like the whole one than the model is.
  SampledEstimate correct() {
    std::vector<FastSample> compared;
    for (const auto& simulated : samples_) {
      const SampleRun& run = *simulated;
      GpuConfig config = run.machine.config;
      config.fast.stride = 1;  // the sample is small, and tells how far the model is off, not the draw
      const FastRun fast = run_fast(reader_, run.groups, {}, config, {});
      FastSample sample;
      sample.groups = run.groups;
      for (const std::uint64_t group : run.groups) sample.weight.push_back(all_[group]->sectors);
      sample.end = run.times.ended;
      sample.fast_end.assign(fast.group_end.begin(), fast.group_end.end());
      compared.push_back(std::move(sample));
    }
    const FastCorrection correction = correct_fast(compared);
    correction_ = std::exp(correction.log_factor);
    residual_ = correction.residual;
    SampledEstimate estimate;
    estimate.log_cycles = std::log(std::max(1.0, static_cast<double>(whole_fast_.cycles()))) + correction.log_factor;
    estimate.degrees_of_freedom = correction.degrees_of_freedom;
    estimate.prior_variance = correction.prior_variance;
    estimate.bias = kVisitsBias;
    estimate.evidence = correction.evidence;
    return estimate;
  }

  SampledEstimate evaluate() {
    std::vector<Observed> observed;
    for (const auto& sample : samples_) {
      Observed one;
      for (const std::uint64_t group : sample->groups) one.groups.push_back(all_[group]);
      one.machine = sample->machine.model;
      one.group_end = sample->times.ended;
      one.cycles = sample->cycles;
      observed.push_back(std::move(one));
    }
    fit_ = fit_rates(observed, prior_of(config_));
    const LogEstimate prediction = predict(all_, known_, model_of(config_), fit_.log_rates);
    SampledEstimate estimate;
    estimate.log_cycles = prediction.value;
    estimate.prior_variance = prior_variance(prediction.gradient, fit_);
    estimate.degrees_of_freedom = fit_.degrees_of_freedom;
    estimate.bias = kCallsBias;
    residual_ = fit_.residual;
    for (std::size_t s = 0; s < samples_.size(); ++s) {
      for (std::size_t i = 0; i < samples_[s]->groups.size(); ++i) {
        const FittedRates::Group& group = fit_.groups[s][i];
        if (group.weight == 0.0) continue;
        GroupEvidence e{samples_[s]->groups[i], group.weight, group.residual, 0.0};
        for (std::size_t p = 0; p < kFittedRates; ++p) e.influence += prediction.gradient[p] * group.influence[p];
        estimate.evidence.push_back(e);
      }
    }
    return estimate;
  }

  void describe(const SampledResult& r, std::uint64_t groups, modules::StatisticList& list) const {
    const auto add = [&list](const char* name, auto value, const char* unit, const std::string& description) {
      list.add(std::string("gpu.sampled.") + name, value, unit, description);
    };
    report_.describe(r, {groups, samples_.size(), kRunsOfClasses, residual_, kResidualOfEnds}, "", list);
    if (visits()) {
      const modules::RegionCounters l1 = whole_fast_.counters.l1.all();
      add("fast.cycles", static_cast<std::uint64_t>(whole_fast_.cycles()), "cycles", "of fast mode, uncorrected");
      add("fast.correction", correction_, "ratio", "gpu.cycles over them: simulated over modelled ends of warps");
      add("fast.l1_hit_rate", ratio(l1.hits + l1.hits_on_miss, l1.reads), "ratio", "of fast mode");
      add("fast.l2_accesses", whole_fast_.counters.l2.accesses(), "sectors", "of fast mode");
      add("fast.dram_sectors", whole_fast_.counters.memory.traffic.responses, "sectors", "of fast mode");
      return;
    }
    const ModelRates rates = rates_of(fit_.log_rates);
    add("rate.step_cycles", rates.step_cycles, "cycles", "fitted: a step that misses, nothing contended");
    add("rate.sm_sectors", rates.sm_sectors, "sectors/cycle", "fitted: node sectors that an SM serves");
    add("rate.sm_far", rates.sm_far, "sectors/cycle", "fitted: sectors beyond the L2 that an SM can ask for");
    add("rate.memory_sectors", rates.memory_sectors, "sectors/cycle", "fitted: sectors that the DRAM serves");
  }

  static double ratio(std::uint64_t a, std::uint64_t b) {
    return b == 0 ? 0.0 : static_cast<double>(a) / static_cast<double>(b);
  }

  SampledResult finished(const SampledEstimate& estimate) {
    SampledResult r;
    r.estimate = estimate;
    r.cycles = cycles_interval(estimate);
    r.result.cycles = static_cast<Cycle>(std::llround(r.cycles.value));
    std::uint64_t groups = 0;
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      groups += samples_[i]->groups.size();
      for (const std::string& violation : samples_[i]->violations) {
        r.result.violations.push_back(fmt::format("sample {}: {}", i, violation));
      }
    }
    if (visits()) {
      describe_fast(r.result);
    } else {
      describe_samples(r);
    }
    report_.add_energy(r.result.statistics);
    describe(r, groups, r.result.statistics);
    report_.finish(r);
    return r;
  }

  /// Counts of fast mode, in as many cycles as estimated.
  void describe_fast(SimulationResult& result) const {
    GpuCounters counters = whole_fast_.counters;
    const double stretch =
        static_cast<double>(result.cycles) / static_cast<double>(std::max<Cycle>(1, counters.cycles));
    for (modules::LaunchSpan& launch : counters.distributor.launches) {
      launch.end = static_cast<Cycle>(std::llround(static_cast<double>(launch.end) * stretch));
    }
    counters.cycles = result.cycles;
    const std::vector<LowerBound> bounds = lower_bounds(counters, work_.longest, config_);
    result.binding_bound = binding_bound(bounds).name;
    modules::StatisticList& list = result.statistics;
    sim::describe(counters, list);
    sim::describe(bounds, counters.cycles, list);
  }

  /// Counts of the samples on half SMs, scaled.
  void describe_samples(SampledResult& r) const {
    WholeRun whole;
    whole.cycles = r.cycles.value;
    whole.groups = all_.size();
    whole.totals = reader_.totals();
    whole.longest = work_.longest;
    whole.busiest_share = busiest_share();
    std::vector<const ordered_json*> contended;
    double sampled = 0.0;
    for (std::size_t i = 0; i < samples_.size(); i += 2) {
      contended.push_back(&samples_[i]->stats);
      for (const std::uint64_t group : samples_[i]->groups) sampled += all_[group]->sectors;
    }
    r.result.statistics = whole_statistics(contended, sectors_ / sampled, whole, config_);
    for (const modules::Statistic& s : r.result.statistics.items()) {
      if (s.name == "gpu.bound.largest") r.result.binding_bound = s.description.substr(s.description.rfind(' ') + 1);
    }
  }

  double busiest_share() const {
    const std::vector<unsigned> group_sm =
        run_model(all_, known_, model_of(config_), rates_of(fit_.log_rates)).group_sm;
    std::vector<double> by_sm(config_.sms);
    for (std::size_t i = 0; i < all_.size(); ++i) by_sm[group_sm[i]] += all_[i]->sectors;
    return *std::max_element(by_sm.begin(), by_sm.end()) / sectors_;
  }

  std::string path_;
  const GpuConfig& config_;
  SampledOptions options_;
  traces::Reader reader_;
  SampledReport report_;
  TraceWork work_;
  std::vector<const GroupWork*> all_;  ///< of the trace, by index
  double sectors_ = 0.0, squares_ = 0.0;
  std::vector<std::vector<std::uint64_t>> classes_;
  std::vector<std::unique_ptr<SampleRun>> samples_;  ///< with idle neighbours; of `calls`, every other on half an SM
  std::vector<Launch> known_;
  FittedRates fit_;     ///< of the warp model
  FastRun whole_fast_;  ///< of the whole trace
  double correction_ = 1.0;
  double residual_ = 0.0;
};

}  // namespace

double default_share(SampleModel model) { return model == SampleModel::windows ? 0.1 : 1.0 / 16.0; }

void check_sampled(const SampledOptions& options) {
  if (options.share && !(*options.share > 0.0 && *options.share <= 1.0)) {
    throw Error("sampled mode", "--share", "must be above 0 and at most 1");
  }
  if (!(options.target_error >= 0.0 && options.target_error < 1.0)) {
    throw Error("sampled mode", "--target-error", "must be above 0 and below 100%");
  }
}

SampledResult simulate_sampled(const std::string& trace_path, const GpuConfig& config, const SampledOptions& options) {
  check_sampled(options);
  check_config(config, "configuration");
  if (config.dram_model != kBuiltInMemory) {
    throw Error("sampled mode", "dram.model", "must be built_in: fast mode has no other");
  }
  SampledOptions resolved = options;
  if (!resolved.share) resolved.share = default_share(resolved.model);
  if (resolved.model == SampleModel::windows) {
    const traces::Reader reader(trace_path);
    if (windows_fit(reader, config, resolved)) return simulate_windows(reader, config, resolved);
    resolved.model = SampleModel::visits;
    if (!options.share) resolved.share = default_share(resolved.model);
  }
  return SampledRun(trace_path, config, resolved).run();
}

}  // namespace grtx::sim
