// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/estimate/windows/window_report.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "grtx/base/child_process.h"
#include "grtx/base/json.h"
#include "grtx/rtl_tlm/gpu/machine.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"
#include "grtx/rtl_tlm/run/host_speed.h"
#include "grtx/rtl_tlm/run/simulation_inputs.h"
#include "grtx/rtl_tlm/run/statistics_json.h"

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

double cpu_of_all_processes() {
  double seconds = 0.0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(who, &usage);
    for (const timeval& t : {usage.ru_utime, usage.ru_stime}) {
      seconds += static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    }
  }
  return seconds;
}

std::uint64_t peak_rss_of_all_processes() {
  long most = 0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(who, &usage);
    most = std::max(most, usage.ru_maxrss);
  }
  return static_cast<std::uint64_t>(most) * 1024;  // Linux counts in KiB
}

}  // namespace

WindowReport::WindowReport(const traces::Reader& reader, const GpuConfig& config, const WindowOptions& options)
    : reader_(reader), config_(config), options_(options), start_cpu_(cpu_of_all_processes()) {}

std::map<std::string, std::string> WindowReport::inputs() const {
  std::map<std::string, std::string> all = simulation_inputs(reader_, config_);
  all["mode"] = name_of(SimulationMode::windows);
  all["windows.seed"] = std::to_string(options_.seed);
  all["windows.share"] = fmt::format("{}", options_.share);
  if (options_.target_error > 0.0) all["windows.target_error"] = fmt::format("{}", options_.target_error);
  return all;
}

void WindowReport::describe(const EstimatedResult& r, const Sample& sample, const std::string& note,
                            modules::StatisticList& list) const {
  const auto add = [&list](const char* name, auto value, const char* unit, const std::string& description) {
    list.add(std::string("gpu.windows.") + name, value, unit, description, modules::StatisticKind::state);
  };
  const std::uint64_t all = reader_.group_count();
  add("share", all == 0 ? 0.0 : static_cast<double>(sample.groups) / static_cast<double>(all), "ratio",
      "groups simulated over groups of the trace" + (note.empty() ? "" : "; the whole trace: " + note));
  add("groups", sample.groups, "groups", "groups simulated");
  add("residual", r.estimate.whole ? 0.0 : sample.residual, "ratio",
      "root mean square of the cycles of a window that its costs do not explain, over its cycles");
  describe_interval(r, list);
}

// In a child process: pricing needs an elaborated machine, and a process elaborates only once.
void WindowReport::add_energy(WholeStatistics& statistics) const {
  if (!options_.price) return;
  ChildProcess child("energy", [this, &statistics] {
    modules::set_time_resolution_to_fs();
    const IdleMachine machine(config_, reader_.header(), reader_.totals().max_evictions_per_ray);
    ordered_json json = ordered_json::array();
    for (modules::StatisticList counts : {statistics.list, at_ends(statistics, false), at_ends(statistics, true)}) {
      const std::size_t counted = counts.items().size();
      options_.price(config_, machine.inventory(), reader_.totals().rays, counts);
      modules::StatisticList energy;
      for (std::size_t i = counted; i < counts.items().size(); ++i) energy.add(counts.items()[i]);
      json.push_back(list_json(energy));
    }
    return json_text(json);
  });
  const ordered_json json = parse_json(child.result(), "estimate");
  const modules::StatisticList central = list_from_json(json.at(0)), low = list_from_json(json.at(1)),
                               high = list_from_json(json.at(2));
  for (std::size_t i = 0; i < central.items().size(); ++i) {
    const modules::Statistic& s = central.items()[i];
    statistics.intervals[s.name] = {low.items()[i].number(), high.items()[i].number()};
    statistics.list.add(s);
  }
}

void WindowReport::finish(EstimatedResult& r) const {
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  const double cpu = cpu_of_all_processes() - start_cpu_;
  modules::StatisticList& host = r.result.host;
  host.add("host.wall_seconds", wall, "s", "wall time of the whole estimate", modules::StatisticKind::count);
  host.add("host.cpu_seconds", cpu, "s", "processor time of the whole estimate, all processes",
           modules::StatisticKind::count);
  host.add("host.peak_rss_bytes", peak_rss_of_all_processes(), "B", "largest resident memory of a process",
           modules::StatisticKind::largest);
  add_host_speed(host, {r.result.cycles, reader_.totals().visits(), wall, cpu}, config_);
  r.result.inputs = inputs();
  r.result.document =
      statistics_document(config_json(config_), r.result.inputs, r.result.notes, r.result.statistics, r.result.host);
  r.result.document["windows"] = to_json(r.estimate);
  for (const auto& [name, interval] : r.intervals) {
    r.result.document["windows"]["intervals"][name] = {interval.low, interval.high};
  }
}

EstimatedResult WindowReport::whole(const std::string& why) const {
  fmt::print(stderr, "grtx: windows mode: {}: all of it is simulated, in cycle mode: {}\n", reader_.path(), why);
  SimulationOptions options;
  options.price = options_.price;
  EstimatedResult r;
  r.result = simulate_in_child(reader_.path(), config_, options);
  make_whole(r);
  r.result.inputs = inputs();
  modules::StatisticList list;
  describe(r, {reader_.group_count(), 0.0}, why, list);
  add_to_document(list, r);
  r.result.document.at("stats").at("host.cpu_seconds")["value"] = cpu_of_all_processes() - start_cpu_;
  return r;
}

}  // namespace grtx::sim
