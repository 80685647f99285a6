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
#include "grtx/rtl_tlm/observe/timeline.h"
#include "grtx/rtl_tlm/observe/waveform.h"
#include "grtx/rtl_tlm/run/result_notes.h"
#include "grtx/rtl_tlm/run/saved_state.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

/// Prices a run: adds gpu.energy_nj and its parts to the run's counts, which `list` holds already. inventories: of the
/// machine that ran. rays: primary and secondary.
using EnergyPricing = std::function<void(const GpuConfig& config, const std::vector<modules::Inventory>& inventories,
                                         std::uint64_t rays, modules::StatisticList& list)>;

struct SimulationOptions {
  bool quiet = true;
  Cycle watchdog_cycles = 2'000'000;  ///< so many cycles without progress, or anything scheduled, are a deadlock
  std::vector<std::uint64_t> groups;  ///< run only these groups of the trace (ascending); empty: all
  std::string warm_trace;             ///< run before, for what it leaves in caches and DRAM rows; empty: none
  std::string warm_state;             ///< file of what a run has left there (saved_state.h); empty: none
  std::string save_state;             ///< file to write, of what this run leaves there; empty: none
  WaveformOptions waveform;           ///< off when its path is empty
  TimelineOptions timeline;           ///< off when its path is empty
  bool pixel_cycles = false;          ///< fill SimulationResult::pixel_cycles
  modules::WarpObserver* observer = nullptr;  ///< is told of starts and ends of warps; not with pixel_cycles
  EnergyPricing price;                        ///< none: the run has no energy statistics
  BuildOptions build;          ///< threads: as many as asked for; a run that cannot have them says so, unless quiet
  MemorySystemFactory memory;  ///< stands in for what dram.model names
};

struct SimulationResult {
  Cycle cycles = 0;
  modules::StatisticList statistics;          ///< identical for identical inputs
  modules::StatisticList host;                ///< wall time, memory, speed of this machine
  std::map<std::string, std::string> inputs;  ///< hashes of trace and configuration, and what the trace was made from
  std::vector<std::string> violations;        ///< conservation laws that did not hold; empty in a correct run
  ResultNotes notes;                          ///< what limits the meaning of all this
  std::string binding_bound;                  ///< name of the largest lower bound
  std::vector<modules::TimedMisses> timed_misses;  ///< by SM with an L1 of the project, of a sampled run
  nlohmann::ordered_json document;            ///< the statistics file (grtx.stats/1)
  unsigned width = 0, height = 0;             ///< of the image, when pixel_cycles was asked for
  std::vector<std::uint64_t> pixel_cycles;    ///< by pixel: cycles from launch to end of the warps with its rays
};

/// Simulates the trace on the machine, in cycle mode where config.sampling is off. SystemC elaborates once a process: call
/// it once, or each time in a ChildProcess. Throws Error for a bad trace or configuration, std::runtime_error (with all
/// modules' states on stderr) when the model stands still.
SimulationResult simulate(const std::string& trace_path, const GpuConfig& config, const SimulationOptions& options);

}  // namespace grtx::sim
