// SPDX-License-Identifier: Apache-2.0
// A PortedDram as the memory system of a GPU.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/gpu/memory_system.h"
#include "grtx/rtl_tlm/memory/ported_dram.h"

namespace grtx::sim {

using PortedDramBuilder = std::function<std::unique_ptr<PortedDram>(const PortedDramConfig&)>;

class PortedMemory final : public MemorySystem {
 public:
  /// Builds the DRAM for gpu and binds it to all of its sockets. model: as in dram.model.
  PortedMemory(const std::string& model, const PortedDramBuilder& build, Gpu& gpu);

  std::string model() const override { return model_; }
  unsigned channels() const override { return dram_->ports(); }
  MemoryTraffic traffic(unsigned channel) const override;
  std::uint64_t outstanding(unsigned channel) const override { return dram_->port(channel).outstanding(); }
  bool idle() const override { return dram_->idle(); }
  void dump_state(std::ostream& out) const override { dram_->dump_state(out); }
  void statistics(modules::StatisticList& list, const std::string& prefix) const override;

 private:
  std::string model_;
  std::unique_ptr<PortedDram> dram_;
};

}  // namespace grtx::sim
