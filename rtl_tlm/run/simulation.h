// SPDX-License-Identifier: Apache-2.0
// Runs a trace on the GPU model: builds it, steps it to the end, watches over it, checks the conservation laws and
// gathers the statistics.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/gpu_counters.h"
#include "grtx/rtl_tlm/gpu/memory_system.h"
#include "grtx/rtl_tlm/observe/observe_options.h"
#include "grtx/rtl_tlm/run/lower_bounds.h"
#include "grtx/rtl_tlm/run/result_notes.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

/// Adds gpu.energy_nj and its parts to `list`, which holds the run's counts already. inventories: of the machine that
/// ran. rays: primary and secondary.
using EnergyPricing = std::function<void(const GpuConfig& config, const std::vector<modules::Inventory>& inventories,
                                         std::uint64_t rays, modules::StatisticList& list)>;

struct SimulationOptions {
  bool quiet = true;
  Cycle watchdog_cycles = 2'000'000;  ///< cycles without progress and with nothing scheduled that are a deadlock
  std::vector<std::uint64_t> groups;  ///< run only these groups of the trace (ascending); empty: all
  std::string warm_trace;             ///< trace to run first, which warms caches and DRAM rows; empty: none
  std::string warm_state;             ///< file with such contents after another run (saved_state.h); empty: none
  std::string save_state;             ///< file for these contents after this run; empty: none
  WaveformOptions waveform;           ///< off when its path is empty
  TimelineOptions timeline;           ///< off when its path is empty
  bool latency = false;               ///< where reads spend their time: gpu.latency.*
  bool pixel_cycles = false;          ///< fill SimulationResult::pixel_cycles
  modules::WarpObserver* observer = nullptr;  ///< is told when warps start and end; ignored with pixel_cycles
  std::vector<std::uint64_t> read_at;  ///< places in `groups`, ascending: counters are read when they are launched
  std::function<void(Gpu&)> built;     ///< is called when the machine stands, before anything runs; empty: nothing
  EnergyPricing price;                 ///< empty: no energy statistics
  BuildOptions build;
  MemorySystemFactory memory;  ///< replaces the one that dram.model names
};

struct SimulationResult {
  Cycle cycles = 0;
  modules::StatisticList statistics;          ///< identical for identical inputs
  modules::StatisticList host;                ///< wall time, memory, speed of this machine
  std::map<std::string, std::string> inputs;  ///< hashes of trace and configuration, and the trace's inputs
  std::vector<std::string> violations;        ///< conservation laws that did not hold; empty in a correct run
  ResultNotes notes;                          ///< caveats on these figures
  std::vector<LowerBound> bounds;
  std::string binding_bound;                        ///< name of the largest lower bound
  std::vector<modules::StatisticList> at_launches;  ///< statistics so far, when each of `read_at` was launched
  nlohmann::ordered_json document;                  ///< the statistics file (grtx.stats/1)
  unsigned width = 0, height = 0;                   ///< of the image, when pixel_cycles was asked for
  std::vector<std::uint64_t> pixel_cycles;          ///< by pixel: cycles from launch to end of the warps with its rays
};

/// Simulates the trace in cycle mode. SystemC elaborates once per process: call it once, or each time in a
/// ChildProcess. Throws Error for a bad trace or configuration,
/// std::runtime_error (with all modules' states on stderr) on a deadlock of the model.
SimulationResult simulate(const std::string& trace_path, const GpuConfig& config, const SimulationOptions& options);

}  // namespace grtx::sim
