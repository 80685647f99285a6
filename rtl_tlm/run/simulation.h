// Runs a trace on the GPU model: builds it, steps it to the end, watches over it, checks the conservation laws and
// gathers the statistics.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/modules/kernel/statistics.h"
#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/observe/timeline.h"
#include "grtx/rtl_tlm/observe/waveform.h"

namespace grtx::tlm {

enum class SimulationMode : std::uint8_t {
  cycle,  ///< every module, cycle by cycle, in SystemC
  fast    ///< loosely timed (rtl_tlm/fast); no waveforms, timelines or cycles by pixel
};

struct SimulationOptions {
  SimulationMode mode = SimulationMode::cycle;
  bool quiet = true;
  Cycle watchdog_cycles = 2'000'000;  ///< no progress for this many cycles is a deadlock
  std::vector<std::uint64_t> groups;  ///< run only these groups of the trace (ascending); empty: all
  WaveformOptions waveform;           ///< off when its path is empty
  TimelineOptions timeline;           ///< off when its path is empty
  bool pixel_cycles = false;          ///< fill SimulationResult::pixel_cycles
  modules::WarpObserver* observer = nullptr;  ///< is told of starts and ends of warps; not with pixel_cycles
  BuildOptions build;
};

struct SimulationResult {
  Cycle cycles = 0;
  modules::StatisticList statistics;          ///< identical for identical inputs
  modules::StatisticList host;                ///< wall time, memory, speed of this machine
  std::map<std::string, std::string> inputs;  ///< hashes of trace and configuration, and what the trace was made from
  std::vector<std::string> violations;        ///< conservation laws that did not hold; empty in a correct run
  std::string binding_bound;                  ///< name of the largest lower bound
  nlohmann::ordered_json document;            ///< the statistics file (grtx.stats/1)
  unsigned width = 0, height = 0;             ///< of the image, when pixel_cycles was asked for
  std::vector<std::uint64_t> pixel_cycles;    ///< by pixel: cycles from launch to end of the warps with its rays
};

/// Simulates the trace. SystemC elaborates once a process: call it once, or each time in a ChildProcess. Throws Error
/// for a bad trace or configuration, std::runtime_error (with all modules' states on stderr) when the model stands
/// still.
SimulationResult simulate(const std::string& trace_path, const GpuConfig& config, const SimulationOptions& options);

}  // namespace grtx::tlm
