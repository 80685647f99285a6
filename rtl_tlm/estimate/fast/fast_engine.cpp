#include "grtx/rtl_tlm/estimate/fast/fast_engine.h"
#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"

#include <algorithm>
#include <exception>

#include "grtx/base/error.h"
#include "grtx/base/progress.h"
#include "grtx/rtl_tlm/estimate/fast/fast_gpu.h"
#include "grtx/rtl_tlm/gpu/machine.h"
#include "grtx/rtl_tlm/run/trace_source.h"

namespace grtx::sim {

void FastEngine::prepare(const Work& work) {
  const SimulationOptions& options = work.options;
  if (!options.waveform.path.empty() || !options.timeline.path.empty() || options.pixel_cycles) {
    throw Error("sim", "--mode fast", "has no waveforms, timelines or heat maps: use --mode cycle");
  }
  if (has_own_parts(options.build.parts, work.config)) {
    throw Error("sim", "--mode fast", "has the project's units only: use --mode cycle");
  }
  if (options.memory || work.config.dram_model != kBuiltInMemory) {
    throw Error("sim", "--mode fast", "has the built-in DRAM only (dram.model): use --mode cycle");
  }
  first_ = first_sms(work.reader, work.groups, work.config);
  if (work.warm != nullptr) first_before_ = first_sms(*work.warm, all_groups(*work.warm), work.config);
  outside_ = outside_of_measured(work.config, work.groups.size(), work.reader.totals().visits());
  stride_ = fast_stride(work.config, work.reader.totals().visits() * work.groups.size() /
                                         std::max<std::uint64_t>(1, work.reader.group_count()));
}

std::vector<unsigned> FastEngine::first_sms(const traces::Reader& reader, const std::vector<std::uint64_t>& groups,
                                            const GpuConfig& config) {
  std::vector<unsigned> sms;
  if (groups.size() <= std::size_t{config.sms} * config.resident()) return sms;
  try {
    for (const Launch& launch : first_launches(reader, groups, config)) sms.push_back(launch.sm);
  } catch (const std::exception&) {
    traces::check(reader, true);  // a trace that contradicts itself says where
    throw;
  }
  return sms;
}

FinishedRun FastEngine::run(const Work& work, modules::GroupSource& source) {
  const traces::Reader& reader = work.reader;
  const std::uint64_t evictions = reader.totals().max_evictions_per_ray;
  const IdleMachine machine(work.config, reader.header(), evictions);  // what the energy is priced on
  FastGpu gpu(work.config, reader.header(), evictions, source, stride_);
  if (work.warm != nullptr) {
    const traces::Reader& warm = *work.warm;
    TraceSource before(warm, all_groups(warm));
    FastGpu first(work.config, warm.header(), warm.totals().max_evictions_per_ray, before,
                  fast_stride(work.config, warm.totals().visits()));
    first.assign(first_before_);
    first.run([](std::uint64_t) {});
    gpu.keep(first);
  }
  if (work.state != nullptr) {
    StateReader state(work.options.warm_state, work.state->units);
    gpu.load(state);
    state.require_end();
  }
  gpu.observe(work.options.observer);
  gpu.assign(first_);
  Progress progress("simulate", source.count(), "warps", work.options.quiet);
  gpu.run([&](std::uint64_t ended) { progress.set(ended); });
  progress.finish();
  FinishedRun finished;
  finished.counters = gpu.counters();
  finished.inventories = machine.inventory();
  if (!gpu.idle()) finished.violations.push_back("the GPU is not empty at the end");
  finished.ticks = gpu.steps();
  if (!work.options.save_state.empty()) {
    StateWriter state;
    gpu.save(state);
    finished.units = state.bytes();
    finished.memory_bytes = memory_bytes(work.config, reader);
    if (work.warm != nullptr) {
      finished.memory_bytes = std::max(finished.memory_bytes, memory_bytes(work.config, *work.warm));
    }
    if (work.state != nullptr) finished.memory_bytes = std::max(finished.memory_bytes, work.state->memory_bytes);
  }
  return finished;
}

void FastEngine::describe(modules::StatisticList& list) const {
  list.add("gpu.fast.stride", std::uint64_t{stride_}, "events",
           "one in so many of a lane's events took time; what these alone are counted for is estimated");
}

}  // namespace grtx::sim
