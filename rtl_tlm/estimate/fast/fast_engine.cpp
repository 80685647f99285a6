#include "grtx/rtl_tlm/estimate/fast/fast_engine.h"
#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"

#include <algorithm>
#include <exception>

#include "grtx/base/error.h"
#include "grtx/base/progress.h"
#include "grtx/rtl_tlm/estimate/fast/fast_gpu.h"
#include "grtx/rtl_tlm/estimate/fast/measured_region.h"
#include "grtx/rtl_tlm/gpu/machine.h"

namespace grtx::sim {

void FastEngine::prepare(const Work& work) {
  const SimulationOptions& options = work.options;
  if (!options.waveform.path.empty() || !options.timeline.path.empty() || options.pixel_cycles) {
    throw Error("sim", "--mode fast", "has no waveforms, timelines or heat maps: use --mode cycle");
  }
  if (options.memory || work.config.dram_model != kBuiltInMemory) {
    throw Error("sim", "--mode fast", "has the built-in DRAM only (dram.model): use --mode cycle");
  }
  if (work.groups.size() > std::size_t{work.config.sms} * work.config.resident_warps) {
    try {
      first_ = first_launches(work.reader, work.groups, work.config);
    } catch (const std::exception&) {
      traces::check(work.reader, true);  // a trace that contradicts itself says where
      throw;
    }
  }
  outside_ = outside_of_measured(work.config, work.groups.size());
  stride_ = fast_stride(work.config, work.reader.totals().visits() * work.groups.size() /
                                         std::max<std::uint64_t>(1, work.reader.group_count()));
}

FinishedRun FastEngine::run(const Work& work, modules::GroupSource& source) {
  const traces::Reader& reader = work.reader;
  const std::uint64_t evictions = reader.totals().max_evictions_per_ray;
  const IdleMachine machine(work.config, reader.header(), evictions);  // what the energy is priced on
  FastGpu gpu(work.config, reader.header(), evictions, source, stride_);
  gpu.observe(work.options.observer);
  std::vector<unsigned> sms;
  for (const Launch& launch : first_) sms.push_back(launch.sm);
  gpu.assign(std::move(sms));
  Progress progress("simulate", source.count(), "warps", work.options.quiet);
  gpu.run([&](std::uint64_t ended) { progress.set(ended); });
  progress.finish();
  FinishedRun finished;
  finished.counters = gpu.counters();
  finished.inventories = machine.inventory();
  if (!gpu.idle()) finished.violations.push_back("the GPU is not empty at the end");
  finished.ticks = gpu.steps();
  return finished;
}

void FastEngine::describe(modules::StatisticList& list) const {
  list.add("gpu.fast.stride", std::uint64_t{stride_}, "events",
           "one in so many of a lane's events took time; what these alone are counted for is estimated");
}

}  // namespace grtx::sim
