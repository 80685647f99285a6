// SPDX-License-Identifier: Apache-2.0
// A memory system made of any TLM-2.0 targets: a monitor on each of the GPU's memory sockets counts what the simulator
// needs, optionally behind a protocol checker.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "grtx/modules/tlm/at_monitor.h"
#include "grtx/modules/tlm/at_protocol_checker.h"
#include "grtx/rtl_tlm/gpu/memory_system.h"

namespace grtx::sim {

/// Bind socket(i) to the target of L2 slice i; slices may share a target. Derive a class that holds the targets and
/// adds what only they know.
class MonitoredMemory : public MemorySystem {
 public:
  /// check: breaches of the base protocol become violations of the run; costs a hash look-up per call.
  MonitoredMemory(Gpu& gpu, std::string model, bool check = false);

  using Socket = tlm_utils::simple_initiator_socket<modules::AtMonitor, 32>;
  Socket& socket(unsigned channel) { return monitors_.at(channel)->initiator; }

  std::string model() const override { return model_; }
  unsigned channels() const override { return static_cast<unsigned>(monitors_.size()); }
  MemoryTraffic traffic(unsigned channel) const override { return monitors_.at(channel)->traffic(); }
  std::uint64_t outstanding(unsigned channel) const override { return monitors_.at(channel)->outstanding(); }
  bool idle() const override;
  void dump_state(std::ostream& out) const override;
  /// The traffic and .latency, the mean in ns from request to response.
  void statistics(modules::StatisticList& list, const std::string& prefix) const override;
  std::vector<std::string> violations() const override;
  /// Monitors and checkers count from 0; the targets keep what they hold. A class that counts itself overrides this.
  bool restart(modules::Caches caches) override;

 private:
  std::string model_;
  std::vector<std::unique_ptr<modules::AtProtocolChecker>> checkers_;  ///< by channel; empty without `check`
  std::vector<std::unique_ptr<modules::AtMonitor>> monitors_;          ///< by channel
};

}  // namespace grtx::sim
