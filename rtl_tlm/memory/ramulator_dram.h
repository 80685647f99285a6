// SPDX-License-Identifier: Apache-2.0
// DRAM simulated by Ramulator 2.1 (CMU-SAFARI/ramulator2), an external library that is linked only when the build is
// told where it is (GRTX_RAMULATOR). One AT target socket per slice; Ramulator's clock is a clock domain of its own.
// Calls Ramulator once per DRAM clock, also for clocks without requests, because of refresh.
#pragma once

#include <iosfwd>
#include <memory>
#include <systemc>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/rtl_tlm/memory/ported_dram.h"

namespace grtx::sim {

class RamulatorDram final : public sc_core::sc_module, public PortedDram {
 public:
  /// config.file: in YAML as Ramulator exports it, with front end "External". Throws Error when Ramulator refuses it.
  /// Ramulator wraps addresses beyond its capacity.
  RamulatorDram(const sc_core::sc_module_name& name, const PortedDramConfig& config);
  ~RamulatorDram() override;

  unsigned ports() const override;
  DramPort& port(unsigned slice) override;
  const DramPort& port(unsigned slice) const override;
  std::uint64_t period_fs() const override { return clock_->period_fs(); }
  unsigned burst_bytes() const override;
  bool idle() const override;
  void dump_state(std::ostream& out) const override;
  /// Ramulator's own statistics, in its own words.
  void print_own_statistics(std::ostream& out);

 private:
  class Device;  ///< hides the headers of Ramulator
  std::unique_ptr<modules::ClockDomain> clock_;
  std::unique_ptr<Device> device_;
};

}  // namespace grtx::sim
