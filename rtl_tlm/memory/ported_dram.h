// SPDX-License-Identifier: Apache-2.0
// Common interface of the adapters to external DRAM simulators: one DramPort per slice.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>

#include "grtx/modules/messages/address_interleave.h"
#include "grtx/rtl_tlm/memory/dram_port.h"

namespace grtx::sim {

struct PortedDramConfig {
  std::string file;  ///< the simulator's own configuration
  modules::AddressInterleave interleave{};
  bool per_slice = true;               ///< each channel is a memory of its own with local addresses, else one memory
                                       ///< for all with global addresses
  std::uint64_t bytes = 0;             ///< size of the memory map; addresses beyond are refused; 0: unlimited
  std::uint64_t fixed_latency_fs = 0;  ///< added to every response, rounded up to the DRAM's clock
};

/// Number of simulated memories; the memory of a slice; an address inside that memory.
inline unsigned memories(const PortedDramConfig& config) {
  return config.per_slice ? config.interleave.dram_channels() : 1;
}
inline unsigned memory_of(const PortedDramConfig& config, unsigned slice) {
  return config.per_slice ? config.interleave.channel(slice) : 0;
}
inline std::uint64_t address_in_memory(const PortedDramConfig& config, unsigned slice, std::uint64_t address) {
  return config.per_slice ? config.interleave.in_channel(config.interleave.local(address), slice) : address;
}

class PortedDram {
 public:
  virtual ~PortedDram() = default;
  virtual unsigned ports() const = 0;
  virtual DramPort& port(unsigned slice) = 0;
  virtual const DramPort& port(unsigned slice) const = 0;
  virtual std::uint64_t period_fs() const = 0;  ///< of the DRAM's clock
  virtual unsigned burst_bytes() const = 0;     ///< moved by one access
  virtual bool idle() const = 0;                ///< nothing under way
  virtual void dump_state(std::ostream& out) const = 0;
};

}  // namespace grtx::sim
