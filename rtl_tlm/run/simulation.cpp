// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/simulation.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>

#include "grtx/base/error.h"
#include "grtx/base/progress.h"
#include "grtx/base/stopwatch.h"
#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/cache/request_stages.h"
#include "grtx/modules/kernel/unit_fault.h"
#include "grtx/rtl_tlm/gpu/gpu_counters.h"
#include "grtx/rtl_tlm/gpu/machine.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"
#include "grtx/rtl_tlm/observe/timeline.h"
#include "grtx/rtl_tlm/observe/waveform.h"
#include "grtx/rtl_tlm/rtl/rtl_fault.h"
#include "grtx/rtl_tlm/run/conservation.h"
#include "grtx/rtl_tlm/run/host_speed.h"
#include "grtx/rtl_tlm/run/launch_counters.h"
#include "grtx/rtl_tlm/run/measured_source.h"
#include "grtx/rtl_tlm/run/occupancy_series.h"
#include "grtx/rtl_tlm/run/pixel_cycles.h"
#include "grtx/rtl_tlm/run/run_report.h"
#include "grtx/rtl_tlm/run/saved_state.h"
#include "grtx/rtl_tlm/run/simulation_inputs.h"
#include "grtx/rtl_tlm/run/statistics_json.h"
#include "grtx/rtl_tlm/run/switched_source.h"
#include "grtx/rtl_tlm/run/trace_source.h"
#include "grtx/rtl_tlm/run/watchdog.h"
#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {
namespace {

constexpr Cycle kStepCycles = 65536;     ///< between two checks by watchdog and progress bar
constexpr Cycle kDrainStepCycles = 256;  ///< the same while prefetches and write-backs drain

/// User and system time so far, of all threads of the process and of its children that have ended.
double cpu_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  rusage children{};
  getrusage(RUSAGE_CHILDREN, &children);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec) + seconds(children.ru_utime) +
         seconds(children.ru_stime);
}

std::uint64_t peak_rss_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // Linux counts in KiB
}

[[noreturn]] void throw_deadlock(const Gpu& gpu, const MemorySystem& memory, const std::string& why) {
  gpu.dump_state(std::cerr);
  memory.dump_state(std::cerr);
  throw std::runtime_error(fmt::format("deadlock in core cycle {}: {}", gpu.core().cycle(), why));
}

/// Steps the kernel until the last warp has ended (the GPU pauses it there).
void run_to_end(Gpu& gpu, const MemorySystem& memory, std::uint64_t groups, const SimulationOptions& options,
                OccupancySeries& series) {
  const Cycle step = std::min(kStepCycles, std::max(Cycle{1}, options.watchdog_cycles));
  Watchdog watchdog(gpu, memory, options.watchdog_cycles, step);
  Progress progress("simulate", groups, "warps", options.quiet);
  Cycle at = 0;
  while (!gpu.finished()) {
    const Cycle length = std::min(step, series.next() - at);
    run_for(gpu, length);
    at += length;
    if (at == series.next() && !gpu.finished()) series.sample();
    const std::uint64_t ended = gpu.distributor().launched() - gpu.distributor().running();
    progress.set(ended);
    if (gpu.finished()) break;
    if (const std::string why = watchdog.deadlock(); !why.empty()) {
      throw_deadlock(gpu, memory, fmt::format("{} but {} of {} warps have not ended", why, groups - ended, groups));
    }
  }
  progress.finish();
}

/// Steps on until no request is in flight.
void drain(Gpu& gpu, const MemorySystem& memory, const SimulationOptions& options) {
  Watchdog watchdog(gpu, memory, options.watchdog_cycles, kDrainStepCycles);
  while (!(gpu.idle() && memory.idle())) {
    run_for(gpu, kDrainStepCycles);
    if (gpu.idle() && memory.idle()) break;
    if (const std::string why = watchdog.deadlock(); !why.empty()) {
      throw_deadlock(gpu, memory, why + " but requests are under way after the last warp");
    }
  }
}

/// Opens and checks the trace that warms the caches, if there is one.
std::unique_ptr<traces::Reader> warm_reader(const SimulationOptions& options, const traces::Reader& reader) {
  if (options.warm_trace.empty()) return nullptr;
  if (!options.waveform.path.empty() || !options.timeline.path.empty() || options.pixel_cycles || options.observer) {
    throw Error("sim", "--warm", "has no waveforms, timelines or heat maps");
  }
  auto warm = std::make_unique<traces::Reader>(options.warm_trace);
  warm->verify_content();
  if (!same_hardware(warm->header(), reader.header())) {
    throw Error(options.warm_trace, "header", "is for other hardware than " + reader.path());
  }
  if (addressed_scene(warm->header()) != addressed_scene(reader.header())) {
    throw Error(options.warm_trace, "header", "is of another scene or structure than " + reader.path());
  }
  return warm;
}

/// The inputs of a run, which outlive it.
struct RunInputs {
  const traces::Reader& reader;
  const GpuConfig& config;
  const SimulationOptions& options;
  const traces::Reader* warm = nullptr;  ///< options.warm_trace
  const SavedState* state = nullptr;     ///< options.warm_state
};

/// Opens and checks the state from which the run begins, if there is one.
std::optional<SavedState> warm_state(const SimulationOptions& options, const GpuConfig& config,
                                     const traces::Reader& reader) {
  if (options.warm_state.empty()) return std::nullopt;
  if (!options.warm_trace.empty()) throw Error("sim", "--warm-state", "stands for --warm: give one of them");
  SavedState state = read_state(options.warm_state);
  require_fits(state, options.warm_state, config, reader, std::string(name_of(SimulationMode::cycle)));
  return state;
}

/// Content hashes of the traces that warmed the caches; "" if none did.
std::string warming_traces(const RunInputs& work) {
  if (work.state != nullptr) return work.state->ran;
  return work.warm != nullptr ? work.warm->content_hash() : "";
}

void save_state(const RunInputs& work, FinishedRun& finished) {
  const std::string before = warming_traces(work);
  write_state(work.options.save_state,
              {std::string(name_of(SimulationMode::cycle)), config_hash(work.config), hardware_of(work.reader.header()),
               addressed_scene(work.reader.header()), (before.empty() ? "" : before + " ") + work.reader.content_hash(),
               camera_of(work.reader), finished.memory_bytes, std::move(finished.units)});
}

std::map<std::string, std::string> inputs_of(const RunInputs& work) {
  const traces::Reader& reader = work.reader;
  const SimulationOptions& options = work.options;
  std::map<std::string, std::string> inputs = simulation_inputs(reader, work.config);
  add_run_before(inputs, warming_traces(work),
                 work.state != nullptr  ? work.state->camera
                 : work.warm != nullptr ? camera_of(*work.warm)
                                        : "");
  if (!options.groups.empty()) inputs["groups"] = fmt::format("{} of {}", options.groups.size(), reader.group_count());
  return inputs;
}

void add_host_statistics(modules::StatisticList& host, const HostWork& work, const GpuConfig& config,
                         std::uint64_t ticks) {
  host.add("host.wall_seconds", work.wall_seconds, "s", "wall time of building and running the model",
           modules::StatisticKind::count);
  host.add("host.cpu_seconds", work.cpu_seconds, "s", "processor time of building and running the model, all threads",
           modules::StatisticKind::count);
  host.add("host.peak_rss_bytes", peak_rss_bytes(), "B", "largest resident memory of the process",
           modules::StatisticKind::largest);
  add_host_speed(host, work, config);
  host.add("host.ticks", ticks, "ticks", "core cycles that were not skipped", modules::StatisticKind::count);
}

/// The kernel's own reports are numbered, and those of the project have known types: any other is a user's unit's.
bool is_of_a_users_unit(const sc_core::sc_report& report) {
  const std::string_view text = report.what();
  const std::size_t severity = text.find(": ");
  const bool numbered = severity != text.npos && text.substr(severity + 2).starts_with("(");
  return !numbered && !std::string_view(report.get_msg_type()).starts_with("/grtx/");
}

/// Rethrows an exception of a process of the model, which arrives as the kernel's report. A contradictory trace is bad
/// input: its check tells where. A user's unit may report what it likes. Everything else is an internal error.
[[noreturn]] void rethrow(const traces::Reader& reader, const MeasuredSource& source,
                          const sc_core::sc_report& report) {
  if (source.failure()) std::rethrow_exception(source.failure());
  if (report.get_msg_type() == std::string_view(modules::AtInitiator::kReport)) {
    throw Error("memory", "", report.get_msg());  // a memory system that does not fit the run is bad input, too
  }
  const char* process = report.get_process_name();
  const std::string where =
      fmt::format("{}at {}", process == nullptr ? "" : fmt::format("{}, ", process), report.get_time().to_string());
  const std::string_view type = report.get_msg_type();
  if (type == modules::kUnitReport || type == modules::kInputReport) traces::check(reader, true);
  if (type == modules::kInputReport) {
    const std::string_view text = report.get_msg();
    constexpr std::string_view kTrace = "trace: ";  // units do not know the file's name
    throw text.starts_with(kTrace) ? Error(reader.path(), "", std::string(text.substr(kTrace.size())))
                                   : Error("", "", std::string(text));
  }
  if (type == kRtlReport || type == modules::kUnitReport) {
    const std::string text = report.get_msg();
    const std::size_t unit = text.find(": ");
    throw Error(text.substr(0, unit), type == modules::kUnitReport ? where : "", text.substr(unit + 2));
  }
  traces::check(reader, true);
  const std::string what = fmt::format("{}: {}", report.get_msg_type(), report.get_msg());
  if (is_of_a_users_unit(report)) throw Error("simulation", where, what);
  throw std::runtime_error(fmt::format("{} ({})", what, where));
}

/// Observers of a run (waveform, timeline and others); each exists only if requested.
class Observers {
 public:
  Observers(Gpu& gpu, const MemorySystem& memory, const RunInputs& work) : header_(work.reader.header()) {
    const SimulationOptions& options = work.options;
    const std::string trace = work.reader.content_hash();
    if (!options.waveform.path.empty()) {
      waveform_ = std::make_unique<Waveform>(options.waveform, gpu, memory, header_,
                                             fmt::format("trace {}\nconfig {}", trace, config_hash(work.config)));
    }
    if (!options.timeline.path.empty()) {
      timeline_ = std::make_unique<Timeline>(options.timeline, gpu, memory, trace, config_hash(work.config));
    }
    gpu.distributor().observe(options.observer);
    if (!options.read_at.empty()) {
      at_launches_ = std::make_unique<LaunchCounters>(gpu, memory, options.read_at, options.observer);
      gpu.distributor().observe(at_launches_.get());
    }
    if (options.pixel_cycles) {
      pixel_cycles_ = std::make_unique<PixelCycles>(header_, work.config.sms, work.config.resident());
      gpu.distributor().observe(pixel_cycles_.get());
    }
  }
  /// Rethrows the error of a file that could not be written.
  void rethrow_failure() const {
    if (waveform_ && waveform_->failure()) std::rethrow_exception(waveform_->failure());
    if (timeline_ && timeline_->failure()) std::rethrow_exception(timeline_->failure());
  }
  void finish(FinishedRun& finished) {
    if (waveform_) waveform_->finish();
    if (timeline_) timeline_->finish();
    if (at_launches_) finished.at_launches = at_launches_->take();
    if (!pixel_cycles_) return;
    finished.width = header_.width;
    finished.height = header_.height;
    finished.pixel_cycles = pixel_cycles_->cycles();
  }

 private:
  const traces::Header& header_;
  std::unique_ptr<Waveform> waveform_;
  std::unique_ptr<Timeline> timeline_;
  std::unique_ptr<PixelCycles> pixel_cycles_;
  std::unique_ptr<LaunchCounters> at_launches_;
};

/// Runs the warming trace, which has `groups` groups, then prepares the machine for the trace to simulate.
void warm_up(Gpu& gpu, MemorySystem& memory, std::uint64_t groups, const RunInputs& work, SwitchedSource& launch,
             modules::GroupSource& source) {
  OccupancySeries unused(gpu, memory);
  run_to_end(gpu, memory, groups, work.options, unused);
  drain(gpu, memory, work.options);
  launch.switch_to(&source);
  if (!memory.restart(modules::Caches::warm)) {
    throw Error("sim", "--warm", "is not for dram.model = " + memory.model());
  }
  gpu.restart(work.reader.header(), work.reader.totals().max_evictions_per_ray, modules::Caches::warm);
}

void load_caches(Gpu& gpu, MemorySystem& memory, const RunInputs& work) {
  StateReader state(work.options.warm_state, work.state->units);
  gpu.load(state);
  if (!memory.load(state)) throw Error("sim", "--warm-state", "is not for dram.model = " + memory.model());
  state.require_end();
}

std::string save_caches(const Gpu& gpu, const MemorySystem& memory) {
  StateWriter state;
  gpu.save(state);
  if (!memory.save(state)) throw Error("sim", "--save-state", "is not for dram.model = " + memory.model());
  return state.bytes();
}

/// Caches of somebody else are not observed.
void observe_reads(Gpu& gpu, modules::RequestStages* stages) {
  for (const auto& sm : gpu.sms()) {
    if (auto* l1 = dynamic_cast<modules::L1Cache*>(&sm->l1())) l1->observe(stages);
  }
  for (const auto& slice : gpu.slices()) {
    if (auto* l2 = dynamic_cast<modules::L2Slice*>(slice.get())) l2->observe(stages);
  }
}

FinishedRun run_machine(const RunInputs& work, modules::GroupSource& source) {
  const traces::Reader& reader = work.reader;
  const GpuConfig& config = work.config;
  const SimulationOptions& options = work.options;
  FinishedRun finished;
  BuildOptions build = options.build;
  const std::unique_ptr<TraceSource> before =
      work.warm == nullptr ? nullptr : std::make_unique<TraceSource>(*work.warm, all_groups(*work.warm), kDecodeAhead);
  SwitchedSource launch(before ? *before : source);
  const traces::Reader& first = before ? *work.warm : reader;
  build.memory_bytes = std::max(memory_bytes(config, reader), work.state == nullptr ? 0 : work.state->memory_bytes);
  Gpu gpu("gpu", config, first.header(), first.totals().max_evictions_per_ray, launch, build);
  const PauseAtEnd pause("pause_at_end", gpu);
  const std::unique_ptr<MemorySystem> memory = make_memory(options.memory, gpu, build);
  finished.memory_bytes = gpu.memory_bytes();  // includes the need of the warming trace
  Observers observers(gpu, *memory, work);
  if (options.built) options.built(gpu);
  if (before) warm_up(gpu, *memory, before->count(), work, launch, source);
  if (work.state != nullptr) load_caches(gpu, *memory, work);
  modules::RequestStages stages;
  if (options.latency) observe_reads(gpu, &stages);
  OccupancySeries series(gpu, *memory);
  SettledCounters end;
  try {
    run_to_end(gpu, *memory, source.count(), options, series);
    end = settle(gpu, *memory);
    finished.over_time = series.json(gpu.distributor().end_cycle());
    drain(gpu, *memory, options);
  } catch (const sc_core::sc_report&) {  // perhaps an observer could not write its file
    observers.rethrow_failure();
    throw;
  }
  observers.finish(finished);
  finished.counters = collect_counters(gpu, *memory, end);
  finished.violations = emptiness_violations(gpu, *memory);
  for (std::string& violation : memory->violations()) finished.violations.push_back(std::move(violation));
  stages.describe(finished.latency);
  if (std::string violation = stages.violation(); !violation.empty()) finished.violations.push_back(violation);
  finished.inventories = inventory_of(gpu, *memory);
  finished.ticks = gpu.core().ticks();
  if (!options.save_state.empty()) finished.units = save_caches(gpu, *memory);
  return finished;
}

}  // namespace

SimulationResult simulate(const std::string& trace_path, const GpuConfig& config, const SimulationOptions& options) {
  if (sc_core::sc_get_status() != sc_core::SC_ELABORATION) {
    throw std::logic_error("a process can simulate once only");
  }
  check_config(config, "configuration");
  const traces::Reader reader(trace_path);
  {
    const Progress progress("checking the trace", 0, "", options.quiet);
    reader.verify_content();
  }
  const traces::Header& header = reader.header();
  const auto start = std::chrono::steady_clock::now();
  const double cpu_start = cpu_seconds();

  const std::vector<std::uint64_t> groups = options.groups.empty() ? all_groups(reader) : options.groups;
  const std::unique_ptr<traces::Reader> warm = warm_reader(options, reader);
  const std::optional<SavedState> state = warm_state(options, config, reader);
  const RunInputs work{reader, config, options, warm.get(), state ? &*state : nullptr};
  modules::set_time_resolution_to_fs();
  TraceSource file(reader, groups, kDecodeAhead);
  MeasuredSource source(file, header, ChainLatencies(config, header));

  SimulationResult result;
  nlohmann::ordered_json over_time;
  result.inputs = inputs_of(work);
  try {
    FinishedRun finished = run_machine(work, source);
    const GpuCounters& counters = finished.counters;
    over_time = std::move(finished.over_time);
    if (counters.memory.model != config.dram_model) result.inputs["memory"] = counters.memory.model;
    result.width = finished.width;
    result.height = finished.height;
    result.pixel_cycles = std::move(finished.pixel_cycles);
    report_run(finished, source, config, options.price, result);
    if (options.groups.empty() && !(source.totals() == reader.totals())) {
      result.violations.push_back("the groups of the trace do not add up to its totals");
    }
    add_host_statistics(
        result.host, {result.cycles, counters.rt.memory.node_visits(), seconds_since(start), cpu_seconds() - cpu_start},
        config, finished.ticks);
    if (!options.save_state.empty() && result.violations.empty()) save_state(work, finished);
  } catch (const sc_core::sc_report& report) {
    rethrow(reader, source, report);
  }
  result.document =
      statistics_document(config_json(config), result.inputs, result.notes, result.statistics, result.host, over_time);
  return result;
}

}  // namespace grtx::sim
