// SPDX-License-Identifier: Apache-2.0
// The GPU as a component of a virtual platform: an sc_module with registers behind a TLM-2.0 socket and an interrupt.
// It never pauses or stops the kernel, starts on command, and may be instantiated several times:
// docs/guide/platform.md.
#pragma once

#include <tlm_utils/simple_target_socket.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <systemc>
#include <tlm>
#include <vector>

#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/memory_system.h"
#include "grtx/rtl_tlm/observe/observe_options.h"
#include "grtx/rtl_tlm/platform/gpu_registers.h"
#include "grtx/rtl_tlm/platform/picture.h"
#include "grtx/rtl_tlm/run/simulation.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

class FunctionalMemory;
class SwitchedSource;
class Waveform;

class GpuComponent final : public sc_core::sc_module {
 public:
  using SC_CURRENT_USER_MODULE = GpuComponent;  // SC_HAS_PROCESS, which SystemC 3 deprecates
  struct Options {
    GpuConfig machine;
    std::vector<std::string> traces;  ///< paths, by number; all for the same hardware (same_hardware())
    GpuParts parts;                   ///< units of your own
    MemorySystemFactory memory;       ///< replaces the one that machine.dram_model names
    std::uint64_t base = 0;           ///< where `memory` begins on the bus; a multiple of 4096
    bool keep_data = false;           ///< the memory is shared: no launch changes a byte of it (BuildOptions)
    /// Files of `grtx trace --contents`, of each trace: `memory`, which must take debug writes, then holds what a
    /// launch reads, and at its end the picture; keep_data is then on. Empty: the memory holds nothing of it.
    std::vector<std::string> contents;
    EnergyPricing price;  ///< none: no energy statistics
    Cycle watchdog_cycles = 2'000'000;
    WaveformOptions waveform;  ///< of all launches; the window is in cycles of each; off when its path is empty
  };
  /// Throws Error for traces that cannot be read or are not of one hardware, and for a bad configuration.
  GpuComponent(const sc_core::sc_module_name& name, const Options& options);
  ~GpuComponent() override;

  /// b_transport and nb_transport: a start takes effect at the annotated time, with the registers as they are when
  /// control is written; of a transfer of several words, control is written last. Registers are read as they are when
  /// the call is made. No DMI. transport_dbg reads and writes as b_transport does without a delay.
  tlm_utils::simple_target_socket<GpuComponent, 32> registers;
  /// High from the end of a launch, or an error, until it is acknowledged.
  sc_core::sc_out<bool> interrupt{"interrupt"};
  /// May stay unbound. While it is high nothing starts; what is under way is abandoned, and the registers are as built.
  sc_core::sc_port<sc_core::sc_signal_in_if<bool>, 1, sc_core::SC_ZERO_OR_MORE_BOUND> reset{"reset"};

  /// May stay unbound. A launch then begins at its next rising edge, which is cycle 0; while it stands none begins. The
  /// frequencies are those of Options::machine, whatever its period.
  sc_core::sc_port<sc_core::sc_signal_in_if<bool>, 1, sc_core::SC_ZERO_OR_MORE_BOUND> clock{"clock"};

  Gpu& gpu() { return *gpu_; }
  MemorySystem& memory() { return *memory_; }
  /// Results of the launches that have ended, in order: the statistics and the document of `grtx sim` except host.*.
  const std::vector<SimulationResult>& results() const { return results_; }

 private:
  void b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay);
  unsigned transport_dbg(::tlm::tlm_generic_payload& payload);
  ::tlm::tlm_response_status access(::tlm::tlm_generic_payload& payload, const sc_core::sc_time& delay);
  GpuState state() const;
  void end_of_elaboration() override;
  void command(std::uint32_t value, const sc_core::sc_time& delay);
  void build_data();
  void start();
  void at_edge();
  void begin_launch();
  void warps_ended();
  void drain();
  void end_launch();
  void sample();
  void watch();
  void abandon();
  void drop_launch();
  void refused(std::uint64_t address, const std::string& what);
  void reset_changed();
  bool abandons() const { return resetting_ || !fault_.what.empty(); }
  bool held_in_reset() const { return reset.size() > 0 && reset->read(); }
  void fail(LaunchError error, const std::string& what);
  std::string picture_fault() const;
  void raise_interrupt();
  sc_core::sc_time cycles(Cycle count) const {
    return sc_core::sc_time::from_value(count * gpu_->core().period_value());
  }
  void signal_interrupt() { interrupt.write(raised_); }

  Options options_;
  std::vector<std::unique_ptr<traces::Reader>> readers_;  ///< by number
  const traces::Reader* last_ = nullptr;                  ///< the one launched last
  std::unique_ptr<const FunctionalMemory> data_;          ///< none without Options::contents
  std::unique_ptr<SwitchedSource> source_;
  std::unique_ptr<Gpu> gpu_;
  std::unique_ptr<MemorySystem> memory_;
  std::unique_ptr<Waveform> waveform_;

  struct Launch;
  std::unique_ptr<Launch> launch_;  ///< under way
  std::vector<SimulationResult> results_;
  std::size_t before_reset_ = 0;  ///< results that the registers no longer tell of
  sc_core::sc_event start_, drain_, watch_, sample_, abandon_, edge_wanted_, interrupt_changed_;
  GpuRegisters written_;
  /// Of the launch that control has asked for.
  struct {
    std::uint32_t trace = 0;
    modules::Caches caches = modules::Caches::cold;
    Picture picture;
  } asked_;
  std::string ran_;     ///< content hashes of the launches since the caches were cold
  bool begun_ = false;  ///< there has been a launch
  bool starting_ = false;
  bool awaits_edge_ = false;  ///< of `clock`, starting
  bool resetting_ = false;    ///< control, or the port, has asked that the launch is abandoned
  bool by_port_ = false;      ///< the port: no error and no interrupt tell of it
  struct Fault {
    std::uint64_t address = 0;
    std::string what;  ///< empty: none since the last start
  } fault_;
  bool done_ = false;
  bool raised_ = false;
  LaunchError error_ = LaunchError::none;
};

}  // namespace grtx::sim
