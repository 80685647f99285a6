// SPDX-License-Identifier: Apache-2.0
// Writes the GPU's state into a value change dump after each cycle of a window. Built only if a waveform is asked for.
// docs/model/observation.md lists the signals.
#pragma once

#include <cstdint>
#include <string>
#include <systemc>
#include <tuple>
#include <utility>
#include <vector>

#include "grtx/modules/kernel/unit_probe.h"
#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/gpu/memory_system.h"
#include "grtx/rtl_tlm/observe/observation.h"
#include "grtx/rtl_tlm/observe/observe_options.h"
#include "grtx/rtl_tlm/observe/unit_probes.h"
#include "grtx/rtl_tlm/observe/vcd_writer.h"
#include "grtx/rtl_tlm/observe/wires.h"

namespace grtx::sim {

/// Path of GTKWave's save file beside the waveform: F.gtkw for F.vcd.
std::string save_file_of(const std::string& vcd_path);

class Waveform final : private CycleObserver {
 public:
  /// Build after the GPU. comment: lines for the header of the file. Throws Error when the scope matches no signal.
  Waveform(const WaveformOptions& options, Gpu& gpu, const MemorySystem& memory, const traces::Header& header,
           const std::string& comment);

  /// Pauses sampling between launches, so that the kernel has no events for it then.
  void rest_while_idle() { rests_while_idle_ = true; }
  /// Writes the end, gives the file its final name, and writes the save file and the filters for GTKWave.
  void finish();
  /// The exception that writing threw during the run, if any.
  const std::exception_ptr& failure() const { return observation_.failure(); }
  std::uint64_t changes() const { return writer_.changes(); }

 private:
  void sample(Cycle now) override;
  bool rests() const override { return rests_while_idle_ && gpu_.finished() && gpu_.idle() && memory_.idle(); }
  void add_own_probes(const sc_core::sc_object& object);

  WaveformOptions options_;
  Gpu& gpu_;
  const MemorySystem& memory_;
  std::string comment_;
  VcdWriter writer_;
  Wires wires_;
  Wire cycle_, launched_, running_, crossbar_requests_, crossbar_replies_;
  std::vector<RtUnitProbe> rt_units_;
  std::vector<SimtProbe> simt_cores_;
  std::vector<L1Probe> l1_caches_;
  std::vector<L2Probe> l2_slices_;
  std::vector<Wire> dram_outstanding_;  ///< by channel
  std::vector<std::pair<MemoryProbe, Wire>> memory_probes_;
  std::vector<std::pair<modules::UnitProbe, Wire>> own_probes_;  ///< of user-supplied units
  template <typename... T>
  using LinkProbes = std::tuple<std::vector<LinkProbe<T>>...>;
  /// By message type; only links with a selected signal.
  LinkProbes<modules::MemoryRequest, modules::MemoryResponse, modules::TraceCall, modules::TraceDone,
             modules::AnyHitBatch, modules::AnyHitDone, modules::NodeFetchBatch, modules::NodeFetchDone,
             modules::LaunchWarp, modules::WarpEnded>
      links_;
  std::uint64_t first_fs_ = 0;  ///< time of the first sample that was written
  std::uint64_t last_fs_ = 0;   ///< time of the last sample
  bool rests_while_idle_ = false;
  Observation observation_;
};

}  // namespace grtx::sim
