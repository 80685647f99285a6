#include "grtx/rtl_tlm/estimate/sampled/sampled_report.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "grtx/base/child_process.h"
#include "grtx/base/json.h"
#include "grtx/rtl_tlm/gpu/machine.h"
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

SampledReport::SampledReport(const traces::Reader& reader, const GpuConfig& config, const SampledOptions& options)
    : reader_(reader), config_(config), options_(options), start_cpu_(cpu_of_all_processes()) {}

std::map<std::string, std::string> SampledReport::inputs() const {
  std::map<std::string, std::string> all = simulation_inputs(reader_, config_);
  all["mode"] = name_of(SimulationMode::sampled);
  all["sampled.seed"] = std::to_string(options_.seed);
  all["sampled.share"] = fmt::format("{}", options_.share);
  all["sampled.engine"] = name_of(options_.engine);
  if (options_.target_error > 0.0) all["sampled.target_error"] = fmt::format("{}", options_.target_error);
  return all;
}

void SampledReport::describe(const SampledResult& r, const Sample& sample, const std::string& note,
                             modules::StatisticList& list) const {
  const auto add = [&list](const char* name, auto value, const char* unit, const std::string& description) {
    list.add(std::string("gpu.sampled.") + name, value, unit, description);
  };
  const std::uint64_t all = reader_.group_count();
  add("share", all == 0 ? 0.0 : static_cast<double>(sample.groups) / static_cast<double>(all), "ratio",
      "groups simulated over groups of the trace" + (note.empty() ? "" : "; the whole trace: " + note));
  add("groups", sample.groups, "groups", "groups simulated");
  add("confidence", kConfidence, "ratio", "probability with which the interval is meant to hold the true value");
  add("cycles_low", r.cycles.low, "cycles", "lower end of the interval on gpu.cycles");
  add("cycles_high", r.cycles.high, "cycles", "upper end of the interval on gpu.cycles");
  add("half_width", r.cycles.half_width, "ratio", "relative half-width of the interval on gpu.cycles");
  add("deviation", r.cycles.deviation, "ratio", "standard deviation of the logarithm of gpu.cycles, all terms");
  add("bias", r.estimate.whole ? 0.0 : r.estimate.bias.cycles, "ratio",
      "of it, what windows leave over however many they are; a measured constant");
  add("residual", r.estimate.whole ? 0.0 : sample.residual, "ratio",
      "root mean square of what a window took beyond what its costs explain, over its cycles");
  add("degrees_of_freedom", r.estimate.whole ? 0.0 : r.estimate.degrees_of_freedom, "1", "of that deviation");
}

// What it is priced on is SystemC modules: in a child.
void SampledReport::add_energy(modules::StatisticList& list) const {
  if (!options_.price) return;
  ChildProcess child("energy", [this, &list] {
    modules::set_time_resolution_to_fs();
    const IdleMachine machine(config_, reader_.header(), reader_.totals().max_evictions_per_ray);
    modules::StatisticList priced = list;
    options_.price(config_, machine.inventory(), reader_.totals().rays, priced);
    ordered_json json = ordered_json::array();
    for (std::size_t i = list.items().size(); i < priced.items().size(); ++i) {
      const modules::Statistic& s = priced.items()[i];
      json.push_back({s.name, std::get<double>(s.value), s.unit, s.description});
    }
    return json_text(json);
  });
  for (const auto& s : parse_json(child.result(), "estimate")) {
    list.add(s.at(0), s.at(1).get<double>(), s.at(2), s.at(3));
  }
}

void SampledReport::finish(SampledResult& r) const {
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  const double cpu = cpu_of_all_processes() - start_cpu_;
  modules::StatisticList& host = r.result.host;
  host.add("host.wall_seconds", wall, "s", "wall time of the whole estimate");
  host.add("host.cpu_seconds", cpu, "s", "processor time of the whole estimate, all processes");
  host.add("host.peak_rss_bytes", peak_rss_of_all_processes(), "B", "largest resident memory of a process");
  add_host_speed(host, {r.result.cycles, reader_.totals().visits(), wall, cpu}, config_);
  r.result.inputs = inputs();
  r.result.document =
      statistics_document(config_json(config_), r.result.inputs, r.result.notes, r.result.statistics, r.result.host);
  r.result.document["sampled"] = to_json(r.estimate);
}

SampledResult SampledReport::whole(const std::string& why) const {
  fmt::print(stderr, "grtx: sampled mode: {}: all of it is simulated, in cycle mode: {}\n", reader_.path(), why);
  ChildProcess child("whole trace", [this] {
    SimulationOptions options;
    options.price = options_.price;
    const SimulationResult result = simulate(reader_.path(), config_, options);
    ordered_json json;
    json["document"] = result.document;
    json["violations"] = result.violations;
    json["binding_bound"] = result.binding_bound;
    return json_text(json);
  });
  const ordered_json json = parse_json(child.result(), "estimate");
  SampledResult r;
  r.result.document = json.at("document");
  r.result.violations = json.at("violations").get<std::vector<std::string>>();
  r.result.notes = notes_from(r.result.document.at("notes"), reader_.path());
  r.result.binding_bound = json.at("binding_bound").get<std::string>();
  ordered_json& stats = r.result.document.at("stats");
  r.result.cycles = stats.at("gpu.cycles").at("value").get<Cycle>();
  r.estimate.log_cycles = std::log(static_cast<double>(r.result.cycles));
  r.estimate.whole = true;
  r.cycles = cycles_interval(r.estimate);
  r.cycles.value = r.cycles.low = r.cycles.high = static_cast<double>(r.result.cycles);  // without rounding
  r.result.inputs = inputs();
  for (const auto& [name, value] : r.result.inputs) r.result.document.at("inputs")[name] = value;
  modules::StatisticList list;
  describe(r, {reader_.group_count(), 0.0}, why, list);
  const ordered_json sampled = statistics_object(list);
  ordered_json all = ordered_json::object();  // host.* stays last
  for (const auto& [name, entry] : stats.items()) {
    if (name.starts_with("host.") && !all.contains("gpu.sampled.share")) all.update(sampled);
    all[name] = entry;
  }
  all.at("host.cpu_seconds")["value"] = cpu_of_all_processes() - start_cpu_;
  stats = std::move(all);
  r.result.document["sampled"] = to_json(r.estimate);
  return r;
}

}  // namespace grtx::sim
