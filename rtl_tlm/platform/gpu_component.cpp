// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/platform/gpu_component.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/modules/tlm/target_rules.h"
#include "grtx/rtl_tlm/gpu/gpu_counters.h"
#include "grtx/rtl_tlm/gpu/machine.h"
#include "grtx/rtl_tlm/observe/waveform.h"
#include "grtx/rtl_tlm/platform/functional_memory.h"
#include "grtx/rtl_tlm/run/conservation.h"
#include "grtx/rtl_tlm/run/measured_source.h"
#include "grtx/rtl_tlm/run/occupancy_series.h"
#include "grtx/rtl_tlm/run/run_report.h"
#include "grtx/rtl_tlm/run/simulation_inputs.h"
#include "grtx/rtl_tlm/run/statistics_json.h"
#include "grtx/rtl_tlm/run/switched_source.h"
#include "grtx/rtl_tlm/run/trace_source.h"
#include "grtx/rtl_tlm/run/watchdog.h"

namespace grtx::sim {
namespace {

constexpr const char* kReport = "/grtx/gpu";
constexpr Cycle kWatchCycles = 65536;
constexpr std::uint64_t kBeforeTheCycle = 1;  // a point of the series shows what was before it, as in `grtx sim`
constexpr std::uint64_t kBaseBytes = 4096;
constexpr Cycle kDrainCycles = 256;  // between two checks whether all is drained, as in `grtx sim`

bool has_rtl(const modules::RtUnitConfig& rt) {
  constexpr auto kRtl = modules::UnitImplementation::rtl;
  return rt.box_implementation == kRtl || rt.transform_implementation == kRtl || rt.checkpoint.implementation == kRtl;
}

}  // namespace

struct GpuComponent::Launch {
  Launch(const traces::Reader& from, const Gpu& gpu, const MemorySystem& memory, const Options& options);
  const traces::Reader* reader;
  TraceSource file;
  MeasuredSource source;
  Watchdog watchdog;
  OccupancySeries series;
  std::map<std::string, std::string> inputs;
  SettledCounters end;
  nlohmann::ordered_json over_time;
  bool drains = false;  ///< all warps have ended
  bool stands_still = false;
};

GpuComponent::Launch::Launch(const traces::Reader& from, const Gpu& gpu, const MemorySystem& memory,
                             const Options& options)
    : reader(&from),
      file(from, all_groups(from), kDecodeAhead),
      source(file, from.header(), ChainLatencies(options.machine, from.header())),
      watchdog(gpu, memory, options.watchdog_cycles, kWatchCycles),
      series(gpu, memory) {}

GpuComponent::GpuComponent(const sc_core::sc_module_name& name, const Options& options)
    : sc_module(name), registers("registers"), options_(options), source_(std::make_unique<SwitchedSource>()) {
  check_config(options_.machine, this->name());
  if (options_.traces.empty()) throw Error(this->name(), "traces", "there must be one at least");
  if (options_.base % kBaseBytes != 0) throw Error(this->name(), "base", "must be a multiple of 4096");
  if (options_.base != 0 && !options_.memory) {
    throw Error(this->name(), "base", "needs a memory: that of the machine begins at 0");
  }
  if (has_rtl(options_.machine.rt)) throw Error(this->name(), "machine", "blocks in RTL cannot be launched twice");
  for (const std::string& path : options_.traces) {
    readers_.push_back(std::make_unique<traces::Reader>(path));
    readers_.back()->verify_content();
    if (!same_hardware(readers_.back()->header(), readers_.front()->header())) {
      throw Error(path, "header", "is for other hardware than " + options_.traces.front());
    }
  }
  build_data();
  const traces::Reader& first = *readers_.front();
  BuildOptions build;
  for (const auto& reader : readers_) {
    build.memory_bytes = std::max(build.memory_bytes, memory_bytes(options_.machine, *reader));
  }
  build.run_ahead = false;  // other modules share the kernel
  build.base = options_.base;
  build.keep_data = options_.keep_data || data_ != nullptr;
  build.parts = options_.parts;
  gpu_ = std::make_unique<Gpu>("gpu", options_.machine, first.header(), first.totals().max_evictions_per_ray, *source_,
                               build);
  for (const auto& slice : gpu_->slices()) {
    slice->on_refusal([this](std::uint64_t address, const std::string& what) { refused(address, what); });
  }
  memory_ = make_memory(options_.memory, *gpu_, build);
  if (!options_.waveform.path.empty()) {
    waveform_ = std::make_unique<Waveform>(options_.waveform, *gpu_, *memory_, first.header(),
                                           "config " + config_hash(options_.machine));
    waveform_->rest_while_idle();
  }
  registers.register_b_transport(this, &GpuComponent::b_transport);
  registers.register_transport_dbg(this, &GpuComponent::transport_dbg);
  SC_METHOD(start);
  sensitive << start_;
  dont_initialize();
  SC_METHOD(warps_ended);
  sensitive << gpu_->distributor().done();
  dont_initialize();
  SC_METHOD(drain);
  sensitive << drain_;
  dont_initialize();
  SC_METHOD(watch);
  sensitive << watch_;
  dont_initialize();
  SC_METHOD(sample);
  sensitive << sample_;
  dont_initialize();
  SC_METHOD(abandon);
  sensitive << abandon_;
  dont_initialize();
  SC_METHOD(signal_interrupt);
  sensitive << interrupt_changed_;
}

void GpuComponent::build_data() {
  if (options_.contents.empty()) return;
  if (!options_.memory) throw Error(name(), "contents", "needs a memory: that of the machine holds no data");
  if (options_.contents.size() != readers_.size()) throw Error(name(), "contents", "must be one file for each trace");
  std::vector<const traces::Reader*> traces;
  for (const auto& reader : readers_) traces.push_back(reader.get());
  data_ = std::make_unique<FunctionalMemory>(options_.contents, traces, options_.machine);
}

GpuComponent::~GpuComponent() {
  if (!waveform_) return;
  try {
    waveform_->finish();
  } catch (const std::exception& error) {
    SC_REPORT_WARNING(kReport, error.what());
  }
}

void GpuComponent::b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay) {
  payload.set_dmi_allowed(false);
  payload.set_response_status(access(payload, delay));
}

void GpuComponent::end_of_elaboration() {
  if (reset.size() > 0) {
    SC_METHOD(reset_changed);
    sensitive << reset->value_changed_event();
  }
  if (clock.size() > 0) {
    SC_METHOD(at_edge);
    sensitive << edge_wanted_;
  }
}

unsigned GpuComponent::transport_dbg(::tlm::tlm_generic_payload& payload) {
  return access(payload, sc_core::SC_ZERO_TIME) == ::tlm::TLM_OK_RESPONSE ? payload.get_data_length() : 0;
}

::tlm::tlm_response_status GpuComponent::access(::tlm::tlm_generic_payload& payload, const sc_core::sc_time& delay) {
  const std::uint64_t first = payload.get_address();
  const std::uint64_t bytes = payload.get_data_length();
  if (const auto refused = modules::common_refusal(payload); refused != ::tlm::TLM_OK_RESPONSE) return refused;
  if (bytes == 0 || payload.get_streaming_width() < bytes) return ::tlm::TLM_BURST_ERROR_RESPONSE;
  if (first >= kGpuRegisterBytes || bytes > kGpuRegisterBytes - first) return ::tlm::TLM_ADDRESS_ERROR_RESPONSE;
  const std::span<unsigned char> data(payload.get_data_ptr(), bytes);
  if (!payload.is_write()) {
    written_.read(first, data, state());
  } else if (!held_in_reset()) {
    written_.write(first, data, state(), [&](std::uint32_t value) { command(value, delay); });
  }
  return ::tlm::TLM_OK_RESPONSE;
}

GpuState GpuComponent::state() const {
  GpuState now;
  now.busy = starting_ || launch_ != nullptr;
  now.done = done_;
  now.error = error_;
  now.cycles = results_.size() == before_reset_ ? 0 : results_.back().cycles;
  now.launches = static_cast<std::uint32_t>(results_.size() - before_reset_);
  now.traces = static_cast<std::uint32_t>(readers_.size());
  now.fault = fault_.address;
  return now;
}

void GpuComponent::command(std::uint32_t value, const sc_core::sc_time& delay) {
  if ((value & ControlBits::kAcknowledge) != 0) {
    raised_ = false;
    interrupt_changed_.notify(delay);
  }
  if ((value & ControlBits::kReset) != 0 && launch_) {
    resetting_ = true;
    abandon_.notify(delay);
  } else if ((value & ControlBits::kReset) != 0 && awaits_edge_) {
    starting_ = awaits_edge_ = false;
    error_ = LaunchError::aborted;
    if ((value & ControlBits::kStart) == 0) raise_interrupt();
  }
  if ((value & ControlBits::kStart) == 0) return;
  if (starting_ || (launch_ && !resetting_)) return fail(LaunchError::busy, "started while a launch is under way");
  starting_ = true;
  done_ = false;
  if (!resetting_) error_ = LaunchError::none;
  asked_ = {written_.trace(), (value & ControlBits::kKeepCaches) != 0 ? modules::Caches::warm : modules::Caches::cold,
            written_.picture()};
  if (!resetting_) start_.notify(delay);
}

// All work under way in the GPU is dropped; requests at the memory cannot be, so they end first.
void GpuComponent::abandon() {
  if (!launch_) return;
  gpu_->hold_requests();
  if (!memory_->idle()) {
    if (!launch_->stands_still) return abandon_.notify(cycles(kDrainCycles));
    resetting_ = starting_ = false;
    return fail(LaunchError::memory, "no reset: the memory system has requests that it does not answer");
  }
  const bool stood_still = launch_->stands_still;
  drop_launch();
  resetting_ = false;
  const bool quiet = std::exchange(by_port_, false) || stood_still;
  if (starting_) return start();
  if (quiet) {
    fault_ = {};
    return;
  }
  if (!fault_.what.empty()) return fail(LaunchError::bus, fault_.what);
  error_ = LaunchError::aborted;
  raise_interrupt();
}

void GpuComponent::drop_launch() {
  watch_.cancel();
  drain_.cancel();
  sample_.cancel();
  source_->switch_to(nullptr);
  const traces::Reader& reader = *launch_->reader;
  gpu_->restart(reader.header(), reader.totals().max_evictions_per_ray, modules::Caches::cold);
  launch_.reset();
  last_ = nullptr;
  ran_.clear();
  error_ = LaunchError::none;
}

void GpuComponent::refused(std::uint64_t address, const std::string& what) {
  if (!fault_.what.empty()) return;  // of this launch the first
  fault_ = {address, what};
  abandon_.notify(sc_core::SC_ZERO_TIME);
}

void GpuComponent::reset_changed() {
  if (!reset->read()) return;
  start_.cancel();
  starting_ = awaits_edge_ = done_ = raised_ = false;
  written_.reset();
  error_ = LaunchError::none;
  fault_ = {};
  before_reset_ = results_.size();
  interrupt_changed_.notify(sc_core::SC_ZERO_TIME);
  if (!launch_) return;
  by_port_ = resetting_ = true;  // also when the line falls before the memory has answered
  abandon_.notify(sc_core::SC_ZERO_TIME);
}

void GpuComponent::start() {
  if (clock.size() == 0) return begin_launch();
  awaits_edge_ = true;
  edge_wanted_.notify(sc_core::SC_ZERO_TIME);
}

void GpuComponent::at_edge() {
  if (!awaits_edge_) return;
  if (!clock->posedge()) return next_trigger(clock->posedge_event());
  awaits_edge_ = false;
  begin_launch();
}

void GpuComponent::begin_launch() {
  starting_ = false;
  fault_ = {};
  if (asked_.trace >= readers_.size()) {
    return fail(LaunchError::no_such_trace, fmt::format("there is no trace {}, but {}", asked_.trace, readers_.size()));
  }
  if (asked_.caches == modules::Caches::warm && last_ != nullptr &&
      addressed_scene(last_->header()) != addressed_scene(readers_[asked_.trace]->header())) {
    return fail(LaunchError::other_scene, "kept caches hold another scene or structure: " + last_->path());
  }
  if (const std::string fault = picture_fault(); !fault.empty()) return fail(LaunchError::picture, fault);
  if (!memory_->restart(asked_.caches) && begun_) {
    return fail(LaunchError::memory, "the memory system " + memory_->model() + " cannot begin anew");
  }
  begun_ = true;
  if (asked_.caches == modules::Caches::cold) ran_.clear();
  const traces::Reader* const before = ran_.empty() ? nullptr : last_;
  const traces::Reader& reader = *readers_[asked_.trace];
  last_ = &reader;
  launch_ = std::make_unique<Launch>(reader, *gpu_, *memory_, options_);
  source_->switch_to(&launch_->source);
  gpu_->restart(reader.header(), reader.totals().max_evictions_per_ray, asked_.caches);
  if (const std::string fault = data_ ? data_->load(*gpu_, asked_.trace) : ""; !fault.empty()) {
    drop_launch();
    return fail(LaunchError::memory, fault);
  }
  launch_->inputs = simulation_inputs(reader, options_.machine);
  add_run_before(launch_->inputs, ran_, before == nullptr ? "" : camera_of(*before));
  if (memory_->model() != options_.machine.dram_model) launch_->inputs["memory"] = memory_->model();
  ran_ += (ran_.empty() ? "" : " ") + reader.content_hash();
  watch_.notify(cycles(kWatchCycles));
  sample_.notify(cycles(launch_->series.next()) - sc_core::sc_time::from_value(kBeforeTheCycle));
}

std::string GpuComponent::picture_fault() const {
  if (asked_.picture.format == PictureFormat::none) return "";
  return data_ ? data_->fault(asked_.picture, asked_.trace)
               : "a picture needs the contents of the trace (Options::contents)";
}

void GpuComponent::sample() {
  if (!launch_ || launch_->drains) return;
  const Cycle now = launch_->series.next();
  launch_->series.sample();
  sample_.notify(cycles(launch_->series.next() - now));
}

// Also called in cycle 0, before any launch: a distributor without groups is done at once.
void GpuComponent::warps_ended() {
  if (!launch_ || !gpu_->finished() || abandons()) return;
  launch_->end = settle(*gpu_, *memory_);
  launch_->over_time = launch_->series.json(gpu_->distributor().end_cycle());
  launch_->drains = true;
  drain();
}

void GpuComponent::drain() {
  if (abandons()) return;
  if (gpu_->idle() && memory_->idle()) return end_launch();
  drain_.notify(cycles(kDrainCycles));
}

void GpuComponent::end_launch() {
  FinishedRun finished;
  finished.counters = collect_counters(*gpu_, *memory_, launch_->end);
  finished.violations = emptiness_violations(*gpu_, *memory_);
  for (std::string& violation : memory_->violations()) finished.violations.push_back(std::move(violation));
  finished.inventories = inventory_of(*gpu_, *memory_);
  SimulationResult& result = results_.emplace_back();
  report_run(finished, launch_->source, options_.machine, options_.price, result);
  result.inputs = std::move(launch_->inputs);
  result.document = statistics_document(config_json(options_.machine), result.inputs, result.notes, result.statistics,
                                        result.host, launch_->over_time);
  launch_.reset();
  source_->switch_to(nullptr);
  watch_.cancel();
  sample_.cancel();
  done_ = true;
  error_ = LaunchError::none;  // also that of a start which was refused meanwhile
  if (!result.violations.empty()) return fail(LaunchError::broken_law, result.violations.front());
  if (const std::string fault = data_ ? data_->store(*gpu_, asked_.trace, asked_.picture) : ""; !fault.empty()) {
    return fail(LaunchError::picture, fault);
  }
  raise_interrupt();
}

void GpuComponent::watch() {
  if (!launch_) return;
  if (const std::string why = launch_->watchdog.deadlock(); !why.empty()) {
    launch_->stands_still = true;
    sample_.cancel();
    return fail(LaunchError::stands_still,
                why + (launch_->drains ? " but requests are under way" : " but warps remain"));
  }
  watch_.notify(cycles(kWatchCycles));
}

void GpuComponent::fail(LaunchError error, const std::string& what) {
  error_ = error;
  raise_interrupt();
  SC_REPORT_WARNING(kReport, fmt::format("{}: {}", name(), what).c_str());
}

void GpuComponent::raise_interrupt() {
  raised_ = true;
  interrupt_changed_.notify(sc_core::SC_ZERO_TIME);
}

}  // namespace grtx::sim
