// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/gpu/built_in_memory.h"

#include <algorithm>

namespace grtx::sim {
namespace {

/// A data bus moves one burst in CCD memory clocks. Two bursts are not counted: the first one's command may come in
/// clock 0, and the channel may have decided on one command ahead of time.
double busy_core_cycles_of(const GpuConfig& machine, const std::vector<modules::DramChannelCounters>& channels) {
  const GpuConfig config = machine.at_bandwidth();
  double busiest = 0.0;
  for (const modules::DramChannelCounters& channel : channels) {
    if (config.dram.perfect || channel.bursts < 2) continue;
    const double clocks = static_cast<double>(channel.bursts - 2) * config.dram.channel.timing.ccd;
    busiest = std::max(busiest, clocks * config.core_mhz / config.memory_mhz);
  }
  return busiest;
}

MemoryTraffic traffic_of(const modules::DramChannelCounters& c) {
  return {c.reads, c.writes, c.bytes, c.responses, c.refused};
}

}  // namespace

BuiltInMemory::BuiltInMemory(Gpu& gpu, const BuildOptions& build)
    : config_(gpu.config().at_bandwidth()),
      clock_("memory_clock", config_.memory_mhz, build.idle_skip),
      dram_("dram", config_.dram_config(gpu.memory_bytes()), clock_),
      ahead_(gpu.core(), clock_, build.run_ahead) {
  for (std::size_t i = 0; i < gpu.dram.size(); ++i) gpu.dram[i].bind(dram_.sockets[i]);
}

MemoryTraffic BuiltInMemory::traffic(unsigned channel) const { return traffic_of(dram_.channel_counters(channel)); }

std::uint64_t BuiltInMemory::progress() const {
  std::uint64_t sum = 0;
  for (const modules::DramChannelCounters& channel : dram_.all_channel_counters()) {
    sum += channel.bursts + channel.responses;
  }
  return sum;
}

double BuiltInMemory::busy_core_cycles() const { return busy_core_cycles_of(config_, dram_.all_channel_counters()); }

std::unique_ptr<MemorySystem> build_built_in_memory(Gpu& gpu, const BuildOptions& build) {
  return std::make_unique<BuiltInMemory>(gpu, build);
}

MemoryCounters built_in_counters(const GpuConfig& config, const std::vector<modules::DramChannelCounters>& at_end,
                                 const modules::DramCounters& drained,
                                 const std::vector<modules::DramChannelCounters>& drained_channels) {
  MemoryCounters counters;
  counters.model = kBuiltInMemory;
  counters.traffic = traffic_of(drained.channel);
  counters.busy_cycles = busy_core_cycles_of(config, at_end);
  modules::describe(drained, drained_channels, counters.statistics, "gpu.dram");
  return counters;
}

}  // namespace grtx::sim
