// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/estimate/windows/scaled_statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <stdexcept>
#include <unordered_map>
#include <utility>

#include "grtx/rtl_tlm/run/lower_bounds.h"
#include "grtx/rtl_tlm/run/statistics_reference.h"

namespace grtx::sim {
namespace {

using modules::Statistic;
using modules::StatisticKind;

/// The statistics of kind exact: all of them, which whole_statistics() holds.
std::map<std::string, std::uint64_t> exact_counts(const GroupRun& run, const WholeRun& whole) {
  const traces::Totals& t = whole.totals;
  const double calls = std::accumulate(run.work.begin(), run.work.end(), 0.0,
                                       [](double sum, const GroupWork& work) { return sum + work.calls; });
  const auto all_calls = static_cast<std::uint64_t>(calls);
  return {{"gpu.distributor.groups", whole.groups},
          {"gpu.rt.calls", all_calls},
          {"gpu.simt.rounds", all_calls},
          {"gpu.rt.node_visits", t.visits()},
          {"gpu.rt.visits_internal", t.visits_internal},
          {"gpu.rt.visits_instance", t.visits_instance},
          {"gpu.rt.visits_leaf", t.visits_leaf},
          {"gpu.rt.culls", t.culls},
          {"gpu.rt.any_hit_calls", t.any_hit_calls},
          {"gpu.simt.ray_rounds", t.rounds},
          {"gpu.rt.checkpoint.entries_written", t.checkpoints_written},
          {"gpu.rt.checkpoint.entries_read", t.checkpoints_read},
          {"gpu.simt.evictions", t.evictions},
          {"gpu.simt.processed", t.processed},
          {"gpu.simt.blended", t.blended},
          {"gpu.simt.warps", whole.groups}};
}

/// Where the measured part of a window begins and ends among the groups that ran.
struct Span {
  std::uint64_t begin = 0, end = 0;
  std::uint64_t stratum = 0;  ///< groups that it stands for
};

std::vector<Span> measured_spans(const std::vector<Window>& windows) {
  std::vector<Span> spans;
  std::uint64_t place = 0;
  for (const Window& window : windows) {
    const std::uint64_t next = place + window.end - window.first;
    spans.push_back({place + window.measured - window.first, next, window.stratum_end - window.stratum_first});
    place = next;
  }
  if (!spans.empty()) --spans.back().end;  // the time after the last launch is the whole run's, too
  return spans;
}

/// The value of a statistic: itself, or one of the two counts of a mean or ratio.
using Count = std::function<double(const Statistic&)>;

/// A count of the whole run: scaled, and what each window has beyond its share.
struct Scaled {
  double value = 0.0;
  std::vector<double> beyond;  ///< by window, scaled up to its stratum
};

class Scaling {
 public:
  Scaling(const GroupRun& run, const std::vector<Window>& windows, const std::vector<GroupCosts>& costs) : run_(run) {
    for (const modules::StatisticList& list : run.at_launches) {
      auto& by_name = at_launches_.emplace_back();
      for (const Statistic& s : list.items()) by_name.emplace(s.name, &s);
    }
    std::vector<GroupCosts> simulated;
    for (const std::uint64_t group : run.groups) simulated.push_back(costs[group]);
    const auto sectors = [](const std::vector<GroupCosts>& all) {
      return std::accumulate(all.begin(), all.end(), 0.0,
                             [](double sum, const GroupCosts& c) { return sum + c.front(); });
    };
    const auto between = [&](double from, double to) { return costs_between(run.times, simulated, from, to).front(); };
    const auto launch = [&](std::uint64_t place) { return run.times.launched[place]; };
    const double end = *std::max_element(run.times.ended.begin(), run.times.ended.end());
    const std::vector<Span> spans = measured_spans(windows);
    const double once = between(0.0, launch(spans.front().begin)) + between(launch(spans.back().end), end);
    factor_ = (sectors(costs) - once) / std::max(1.0, sectors(simulated) - once);
    for (const Span& span : spans) {
      work_.push_back(between(launch(span.begin), launch(span.end)));
      expansion_.push_back(static_cast<double>(span.stratum) /
                           static_cast<double>(std::max<std::uint64_t>(1, span.end - span.begin)));
      spans_.push_back({place_of(span.begin), place_of(span.end)});
    }
  }

  double factor() const { return factor_; }
  /// 1 - share of a window's stratum that was measured.
  double unmeasured(std::size_t window) const { return std::max(0.0, 1.0 - 1.0 / expansion_[window]); }

  Scaled scaled(const Statistic& last, const Count& count) const {
    const auto at = [&](std::size_t place) {
      const auto found = at_launches_[place].find(last.name);
      return found == at_launches_[place].end() ? 0.0 : count(*found->second);
    };
    const double all = count(last), head = at(spans_.front().first), tail = all - at(spans_.back().second);
    Scaled result;
    result.value = head + factor_ * (all - head - tail) + tail;
    std::vector<double> counts;
    for (const auto& [begin, end] : spans_) counts.push_back(at(end) - at(begin));
    const double work = std::accumulate(work_.begin(), work_.end(), 0.0);
    const double rate = std::accumulate(counts.begin(), counts.end(), 0.0) / std::max(1.0, work);
    for (std::size_t i = 0; i < counts.size(); ++i) {
      result.beyond.push_back(expansion_[i] * (counts[i] - rate * work_[i]));
    }
    return result;
  }

  /// beyond: by window, of a value whose logarithm's deviation it makes.
  StatisticInterval interval(double value, const std::vector<double>& beyond) const {
    CycleEstimate estimate;
    estimate.log_cycles = std::log(value);
    for (std::size_t i = 0; i < beyond.size(); ++i) {
      estimate.evidence.push_back({0, 0.0, beyond[i] * std::sqrt(unmeasured(i)) / value});
    }
    const ConfidenceInterval interval = cycles_interval(estimate);
    return {interval.low, interval.high};
  }

 private:
  std::size_t place_of(std::uint64_t launch) const {
    return static_cast<std::size_t>(std::lower_bound(run_.read_at.begin(), run_.read_at.end(), launch) -
                                    run_.read_at.begin());
  }

  const GroupRun& run_;
  std::vector<std::unordered_map<std::string, const Statistic*>> at_launches_;
  std::vector<std::pair<std::size_t, std::size_t>> spans_;  ///< by window: places in at_launches_
  std::vector<double> work_, expansion_;                    ///< by window
  double factor_ = 1.0;
};

/// Of 0 events in a sample the upper end is that of three: so many are missed once in twenty times.
constexpr double kUnseen = 3.0;

class Estimator {
 public:
  Estimator(const Scaling& scaling, WholeStatistics& result) : scaling_(scaling), result_(result) {}

  /// Adds a statistic whose value is scaled; false if its interval has no end.
  bool add_count(const Statistic& s) {
    const auto [value, interval] = count(s);
    if (!std::isfinite(interval.high)) return false;
    Statistic scaled = s;
    if (std::holds_alternative<std::uint64_t>(s.value)) {
      scaled.value = static_cast<std::uint64_t>(std::llround(value));
    } else {
      scaled.value = value;
    }
    add(std::move(scaled), interval);
    return true;
  }

  /// Value and interval of a count.
  std::pair<double, StatisticInterval> count(const Statistic& s) const {
    const Scaled scaled = scaling_.scaled(s, &Statistic::number);
    const double unseen = kUnseen * scaling_.factor();
    if (scaled.value <= 0.0) return {0.0, {0.0, unseen}};
    const StatisticInterval interval = scaling_.interval(scaled.value, scaled.beyond);
    return {scaled.value, {std::max(0.0, interval.low - unseen), interval.high + unseen}};
  }

  /// Adds a mean or ratio, if it was made from anything.
  void add_quotient(const Statistic& s) {
    const Scaled part = scaling_.scaled(s, [](const Statistic& q) { return static_cast<double>(q.of.part); });
    const Scaled whole = scaling_.scaled(s, [](const Statistic& q) { return static_cast<double>(q.of.whole); });
    if (whole.value <= 0.0) return;
    Statistic made = s;
    const double value = part.value / whole.value, unseen = kUnseen * scaling_.factor() / whole.value;
    made.value = value;
    if (value <= 0.0) return add(std::move(made), {0.0, unseen});
    std::vector<double> beyond;
    for (std::size_t i = 0; i < part.beyond.size(); ++i) {
      beyond.push_back((part.beyond[i] - value * whole.beyond[i]) / whole.value);
    }
    const StatisticInterval interval = scaling_.interval(value, beyond);
    if (std::isfinite(interval.high)) add(std::move(made), {interval.low, interval.high});
  }

  void add(Statistic s, const StatisticInterval& interval) {
    result_.intervals[s.name] = interval;
    result_.list.add(std::move(s));
  }

 private:
  const Scaling& scaling_;
  WholeStatistics& result_;
};

/// What follows from misses, and from waiting for them.
constexpr std::array kOfMisses = {"gpu.l1.",
                                  "gpu.l2.",
                                  "gpu.crossbar.",
                                  "gpu.dram.",
                                  "gpu.energy_nj.l2",
                                  "gpu.energy_nj.crossbar",
                                  "gpu.energy_nj.dram",
                                  "gpu.rt.node_fetch_latency",
                                  "gpu.rt.stall.",
                                  "gpu.rt.warp_cycles.",
                                  "gpu.rt.ray_box.queue_cycles",
                                  "gpu.simt.warp_cycles.memory",
                                  "gpu.simt.lsu.blocked_cycles"};
constexpr std::array kBoundsOfMisses = {"l1_miss_port", "l2_port", "dram_bandwidth"};

/// gpu.bound.*: of each unit's work as scaled.
void add_bounds(const GroupRun& run, const WholeRun& whole, const Estimator& estimator, WholeStatistics& result) {
  std::vector<LowerBound> bounds;
  StatisticInterval largest;
  for (LowerBound bound : run.bounds) {
    if (bound.of_chain) continue;  // the longest may be outside the windows
    if (std::ranges::find(kBoundsOfMisses, bound.name) != kBoundsOfMisses.end()) continue;
    const std::string name = kBoundPrefix + bound.name;
    const auto& items = run.statistics.items();
    const auto last = std::find_if(items.begin(), items.end(), [&](const Statistic& s) { return s.name == name; });
    const auto [value, interval] = estimator.count(*last);
    if (!std::isfinite(interval.high)) continue;
    bound.cycles = static_cast<Cycle>(std::llround(value));
    result.intervals[name] = interval;
    largest = {std::max(largest.low, interval.low), std::max(largest.high, interval.high)};
    bounds.push_back(std::move(bound));
  }
  const ConfidenceInterval& cycles = whole.cycles;
  describe(bounds, static_cast<Cycle>(std::llround(cycles.value)), result.list);
  result.binding_bound = binding_bound(bounds).name;
  result.intervals[kBoundPrefix + "largest"] = largest;
  result.intervals[kBoundPrefix + "fraction"] = {largest.low / cycles.high, largest.high / cycles.low};
}

}  // namespace

std::vector<std::uint64_t> launches_to_read(const std::vector<Window>& windows) {
  std::vector<std::uint64_t> places;
  for (const Span& span : measured_spans(windows)) {
    places.push_back(span.begin);
    places.push_back(span.end);
  }
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  return places;
}

WholeStatistics whole_statistics(const GroupRun& run, const std::vector<Window>& windows,
                                 const std::vector<GroupCosts>& costs, const WholeRun& whole) {
  const Scaling scaling(run, windows, costs);
  const std::map<std::string, std::uint64_t> exact = exact_counts(run, whole);
  const ConfidenceInterval& cycles = whole.cycles;
  WholeStatistics result;
  Estimator estimator(scaling, result);
  for (const Statistic& s : run.statistics.items()) {
    if (is_of_one_part(s.name)) continue;
    Statistic known = s;
    if (s.name == "gpu.cycles") {
      known.value = static_cast<std::uint64_t>(std::llround(cycles.value));
      known.description += "; estimated";
      estimator.add(known, {cycles.low, cycles.high});
      continue;
    }
    if (s.name == "gpu.time_us") {
      const double cycle = s.number() / run.cycles;
      known.value = s.number() * (cycles.value / run.cycles);
      estimator.add(known, {cycle * cycles.low, cycle * cycles.high});
      continue;
    }
    switch (s.kind) {
      case StatisticKind::exact:
        if (!exact.contains(s.name)) throw std::logic_error(s.name + " is exact, but no total of a trace gives it");
        known.value = exact.at(s.name);
        result.list.add(known);
        break;
      case StatisticKind::count:
      case StatisticKind::histogram:
        estimator.add_count(s);
        break;
      case StatisticKind::mean:
      case StatisticKind::ratio:
      case StatisticKind::share:
        estimator.add_quotient(s);
        break;
      case StatisticKind::bound:  // below
      case StatisticKind::largest:
      case StatisticKind::smallest:
      case StatisticKind::state:
        break;
    }
  }
  add_bounds(run, whole, estimator, result);
  return result;
}

void leave_out_misses(WholeStatistics& statistics) {
  modules::StatisticList kept;
  for (const Statistic& s : statistics.list.items()) {
    if (std::ranges::any_of(kOfMisses, [&](const char* prefix) { return s.name.starts_with(prefix); })) {
      statistics.intervals.erase(s.name);
    } else {
      kept.add(s);
    }
  }
  statistics.list = std::move(kept);
}

modules::StatisticList at_ends(const WholeStatistics& statistics, bool upper) {
  modules::StatisticList list;
  for (Statistic s : statistics.list.items()) {
    if (const auto found = statistics.intervals.find(s.name); found != statistics.intervals.end()) {
      s.value = upper ? found->second.high : found->second.low;
    }
    list.add(std::move(s));
  }
  return list;
}

}  // namespace grtx::sim
