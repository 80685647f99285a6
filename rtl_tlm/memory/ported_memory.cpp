// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/memory/ported_memory.h"

#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

PortedMemory::PortedMemory(const std::string& model, const PortedDramBuilder& build, Gpu& gpu) : model_(model) {
  const GpuConfig& machine = gpu.config();
  PortedDramConfig dram;
  dram.file = machine.dram_simulator.file;
  dram.interleave = machine.interleave;
  dram.per_slice = machine.dram_simulator.per_slice;
  dram.bytes = gpu.memory_bytes();
  dram.fixed_latency_fs = machine.dram.fixed_latency * modules::ClockDomain::period_fs(machine.memory_mhz);
  dram_ = build(dram);
  for (unsigned i = 0; i < gpu.dram.size(); ++i) gpu.dram[i].bind(dram_->port(i).socket);
}

MemoryTraffic PortedMemory::traffic(unsigned channel) const {
  const DramPortCounters& c = dram_->port(channel).counters();
  return {c.reads, c.writes, c.bytes, c.responses, c.refused};
}

void PortedMemory::statistics(modules::StatisticList& list, const std::string& prefix) const {
  describe_traffic(list, prefix);
  DramPortCounters sum;
  for (unsigned i = 0; i < dram_->ports(); ++i) sum += dram_->port(i).counters();
  list.add(prefix + ".queue_full_clocks", sum.full_clocks, "clocks",
           "a request waited until the DRAM simulator took it, in its own clocks", modules::StatisticKind::count);
  list.add(prefix + ".access_latency", modules::Quotient{sum.inside_clocks, sum.reads + sum.writes, "", ""}, "clocks",
           "mean time in the DRAM simulator, in its own clocks, without the fixed latency",
           modules::StatisticKind::mean);
  list.add(prefix + ".clock_period", static_cast<double>(dram_->period_fs()) * 1e-6, "ns",
           "of the DRAM simulator's clock", modules::StatisticKind::state);
}

}  // namespace grtx::sim
