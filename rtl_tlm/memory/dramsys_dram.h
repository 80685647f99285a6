// SPDX-License-Identifier: Apache-2.0
// DRAM simulated by DRAMSys 5.1 to 5.5 (tukl-msd/DRAMSys), an external library that is linked only when the build is
// told where it is (GRTX_DRAMSYS). DRAMSys is itself a TLM-2.0 AT target; this module stands between it and the slices
// for local addresses, fixed latency and counts. It adds one DRAM clock to a response.
#pragma once

#include <memory>
#include <systemc>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/rtl_tlm/memory/ported_dram.h"

namespace grtx::sim {

class DramsysDram final : public sc_core::sc_module, public PortedDram {
 public:
  /// config.file: in DRAMSys's JSON. Names of other files in it are looked up as that version of DRAMSys does: up
  /// to 5.1 in memspec/, addressmapping/, mcconfig/ and simconfig/ beside it, later relative to it. Throws Error when
  /// DRAMSys refuses the configuration or the memory map does not fit.
  DramsysDram(const sc_core::sc_module_name& name, const PortedDramConfig& config);
  ~DramsysDram() override;

  unsigned ports() const override;
  DramPort& port(unsigned slice) override;
  const DramPort& port(unsigned slice) const override;
  std::uint64_t period_fs() const override { return clock_->period_fs(); }
  unsigned burst_bytes() const override;
  bool idle() const override;
  void dump_state(std::ostream& out) const override;

 private:
  class Front;    ///< clocked module between the slices and DRAMSys
  struct Behind;  ///< hides the headers of DRAMSys
  std::unique_ptr<Behind> behind_;
  std::unique_ptr<modules::ClockDomain> clock_;
  std::unique_ptr<Front> front_;
};

}  // namespace grtx::sim
