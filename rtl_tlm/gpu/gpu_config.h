// SPDX-License-Identifier: Apache-2.0
// The configuration of the whole GPU model: the parameters of all modules, and the keys by which people set them.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "grtx/modules/cache/decide/l1_cache_config.h"
#include "grtx/modules/cache/decide/l2_slice_config.h"
#include "grtx/modules/dram/decide/dram_config.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/address_interleave.h"
#include "grtx/modules/noc/decide/crossbar_config.h"
#include "grtx/modules/rt_unit/rt_unit_config.h"
#include "grtx/modules/simt/decide/simt_core_config.h"
#include "grtx/rtl_tlm/config/config_file.h"
#include "grtx/rtl_tlm/gpu/memory_system.h"
#include "grtx/rtl_tlm/gpu/sm.h"

namespace grtx::sim {

/// Registered links between SMs, crossbar and L2 slices.
struct GpuLinks {
  unsigned latency = 1;
  unsigned capacity = 4;
  void parameters(modules::ParameterList& list) {
    list.add("link_latency", latency, {1, modules::kMaxLatency}, "cycles",
             "of the links between SM, crossbar and L2; part of crossbar.latency at its outputs", modules::kOurs);
    list.add("link_capacity", capacity, {1, modules::kMaxEntries}, "packets", "of the same links", modules::kOurs);
  }
};

/// Keys of external DRAM simulators, which have their own configuration file.
struct DramSimulatorConfig {
  std::string file;
  bool per_slice = true;  ///< a memory for each channel with local addresses, else one for all with global addresses

  void parameters(modules::ParameterList& list) {
    list.add("config", file, {}, "the DRAM simulator's own configuration file", modules::kOurs);
    list.add("per_slice", per_slice,
             "a memory for each channel (dram.channels) with local addresses, else one for all with global ones",
             modules::kOurs);
  }
};

/// Its defaults are the machine `paper`, from which every command starts.
struct GpuConfig {
  /// Sets the readings of the paper that `paper` adds to the defaults of the units (docs/results/readings.md).
  GpuConfig() {
    rt.checkpoint.traffic = modules::TrafficCharging::uncharged;
    rt.memory.queue = 256;
  }

  unsigned sms = 8;
  unsigned resident_warps = 32;              ///< warp slots of an SM
  std::string distribution = "round_robin";  ///< name of a WorkDistribution
  unsigned rt_units = 1;  ///< RT units of an SM; the warp in slot s belongs to RT unit s mod rt_units
  double core_mhz = 1365.0;
  double memory_mhz = 3500.0;
  double dram_gb_s = 0.0;  ///< bandwidth of the built-in DRAM, all channels; 0: as the other keys give it
  std::string dram_model = kBuiltInMemory;  ///< name of the memory system behind the memory sockets
  DramSimulatorConfig dram_simulator;
  modules::RtUnitConfig rt;
  modules::SimtCoreConfig simt;
  modules::L1CacheConfig l1;
  SmLinks sm_links;
  modules::CrossbarConfig crossbar;
  GpuLinks links;
  modules::AddressInterleave interleave;     ///< of addresses over L2 slices and DRAM channels
  std::uint64_t l2_bytes = 4 * 1024 * 1024;  ///< of all slices
  modules::L2SliceConfig l2;                 ///< of a slice; l2_slice() sets its size from l2_bytes
  modules::DramConfig dram;
  modules::OwnKeys own;  ///< keys of user-supplied units, and of units that not every machine has

  /// All keys, in the order of the documentation.
  void parameters(modules::ParameterList& list);
  /// Warps that an SM can hold: gpu.resident_warps, or fewer if the register file has no room.
  unsigned resident() const { return simt.register_file.resident_warps(resident_warps); }

  /// Configurations of units, with the values that the netlist decides (numbers, sizes) filled in.
  SmConfig sm(unsigned index) const;
  modules::CrossbarConfig crossbar_config() const;
  modules::L2SliceConfig l2_slice(unsigned slice) const;
  modules::DramConfig dram_config(std::uint64_t bytes) const;
  /// The same machine without dram.bandwidth_gb_s: the memory clock that gives it, and times that keep their
  /// nanoseconds, rounded up to that clock. Times of the data bus (ccd, ccd_l, turn) stay clocks.
  GpuConfig at_bandwidth() const;
  /// Bandwidth of the data buses of all DRAM channels, GB/s (1e9 B/s).
  double peak_dram_gb_s() const;
};

/// The parameters of `config`, which must outlive them.
std::vector<modules::Parameter> config_keys(GpuConfig& config);

/// Sources of a configuration, from the bottom up: each overrides those before it.
struct ConfigSource {
  std::string machine = {};  ///< a machine's name, or a file over `paper`; "": the keys of `paper` alone
  std::string file = {};     ///< a file, or a machine's name
  std::string design = {};   ///< whose keys they are, for errors
  std::vector<std::pair<std::string, std::string>> design_keys = {};
  std::vector<std::string> settings = {};  ///< each "key=value"
};
struct LoadedConfig {
  GpuConfig config;
  TracerTexts tracer;  ///< tracer options that the files set
  KeyPlaces places;    ///< of keys and, as "tracer.NAME", of options of the tracer; those at their defaults are missing
  RivalKeys rivals;
  std::vector<std::string> files;  ///< all that were read
  std::string machine_hash;        ///< config_hash() of the machine alone
  std::string undesigned_hash;     ///< that of all but the keys of the design
};
/// Throws Error for anything that is unknown, of the wrong type, out of range, or impossible in combination, which is
/// checked when all sources are applied. check: false leaves combinations to a caller that adds keys of a design.
LoadedConfig load_machine(const ConfigSource& source, bool check = true);

/// The configuration of load_machine(): `paper`, the file with its includes or the machine of this name (if `path` is
/// not empty), then the settings "key=value" in order. Options of the tracer are accepted; load_machine() has them.
GpuConfig load_config(const std::string& path, const std::vector<std::string>& settings);
/// The same, starting from `config`. origin: its source, for errors.
GpuConfig load_config(GpuConfig config, const std::string& origin, const std::string& path,
                      const std::vector<std::string>& settings);

/// Throws Error{origin, key, rule} when keys contradict each other.
void check_config(const GpuConfig& config, const std::string& origin);

/// Every key with its resolved value, in table order.
nlohmann::ordered_json config_json(const GpuConfig& config);
/// XXH3 of the resolved configuration, hexadecimal: the same for files that resolve to the same values.
std::string config_hash(const GpuConfig& config);
/// The reference table of all keys, in Markdown (docs/model/configuration.md).
std::string config_reference();

}  // namespace grtx::sim
