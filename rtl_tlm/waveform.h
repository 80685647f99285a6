// Samples the GPU's state into a value change dump, once a tick. Exists only when a waveform was asked for.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <systemc>
#include <vector>

#include "rtl_tlm/gpu.h"
#include "rtl_tlm/vcd_writer.h"

namespace grtx::tlm {

struct WaveformOptions {
  std::string path;         ///< empty: no waveform
  std::string scope = "*";  ///< only signals whose name or enclosing scope matches this shell pattern
  Cycle first = 0;          ///< window in core cycles, both ends included
  Cycle last = modules::kNever;
};

/// Parses "A:B", "A:" or ":B". Throws Error{"--vcd-window", ...}.
void parse_window(const std::string& text, WaveformOptions& options);

class Waveform final : public sc_core::sc_module {
 public:
  SC_HAS_PROCESS(Waveform);
  /// Build after the GPU. comment: lines for the header of the file. Throws Error when the scope matches no signal.
  Waveform(const sc_core::sc_module_name& name, const WaveformOptions& options, const Gpu& gpu,
           const modules::Dram& dram, const std::string& comment);

  /// Writes the end and gives the file its final name. `end`: last core cycle of the run.
  void finish(Cycle end);

 private:
  using Sample = std::function<std::uint64_t()>;
  struct Probe {
    VcdWriter::Signal signal = 0;
    Sample sample;
  };

  void probe(const std::string& name, unsigned width, Sample sample, const std::vector<std::string>& enumeration = {});
  void probe_rt_unit(const std::string& scope, const Sm& sm);
  void on_tick();
  void sample();

  WaveformOptions options_;
  const Gpu& gpu_;
  VcdWriter writer_;
  std::string comment_;
  std::vector<Probe> probes_;
  sc_core::sc_event settled_;  ///< a delta cycle after the tick: every module has done its cycle
  bool begun_ = false;
};

}  // namespace grtx::tlm
