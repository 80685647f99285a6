// SPDX-License-Identifier: Apache-2.0
// The built-in DRAM with its memory clock as a memory system.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "grtx/modules/dram/dram.h"
#include "grtx/modules/kernel/run_ahead.h"
#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/memory_system.h"

namespace grtx::sim {

class BuiltInMemory final : public MemorySystem {
 public:
  /// Binds itself to all sockets of the GPU.
  BuiltInMemory(Gpu& gpu, const BuildOptions& build);

  std::string model() const override { return kBuiltInMemory; }
  unsigned channels() const override { return dram_.channels(); }
  MemoryTraffic traffic(unsigned channel) const override;
  std::uint64_t outstanding(unsigned channel) const override { return dram_.outstanding(channel); }
  bool idle() const override { return dram_.idle(); }
  std::uint64_t progress() const override;
  std::uint64_t awaited_fs() const override { return clock_.time_fs(clock_.latest()); }
  void dump_state(std::ostream& out) const override { dram_.dump_state(out); }
  void statistics(modules::StatisticList& list, const std::string& prefix) const override {
    dram_.statistics(list, prefix);
  }
  double busy_core_cycles() const override;
  bool restart(modules::Caches caches) override {
    clock_.restart(caches);
    return true;
  }
  bool save(StateWriter& state) const override {
    dram_.save(state);
    return true;
  }
  bool load(StateReader& state) override {
    dram_.load(state);
    return true;
  }
  std::optional<modules::Inventory> inventory() const override { return dram_.inventory(); }

  const modules::Dram& dram() const { return dram_; }
  modules::ClockDomain& clock() { return clock_; }

 private:
  GpuConfig config_;
  modules::ClockDomain clock_;
  modules::Dram dram_;
  modules::RunAhead ahead_;  ///< lets both clocks run ahead of the kernel together
};

/// The factory of dram.model = built_in.
std::unique_ptr<MemorySystem> build_built_in_memory(Gpu& gpu, const BuildOptions& build);

/// MemoryCounters from given counts, for tests. at_end: by channel, when the last warp had ended; drained: after
/// draining.
MemoryCounters built_in_counters(const GpuConfig& config, const std::vector<modules::DramChannelCounters>& at_end,
                                 const modules::DramCounters& drained,
                                 const std::vector<modules::DramChannelCounters>& drained_channels);

}  // namespace grtx::sim
