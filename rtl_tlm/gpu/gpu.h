// SPDX-License-Identifier: Apache-2.0
// The GPU: work distributor, SMs, crossbar and L2 slices in one core clock domain, with one TLM-2.0 AT socket per slice
// towards DRAM. Paper: Table I. Cost: the sum of its parts.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iosfwd>
#include <memory>
#include <systemc>
#include <tlm>
#include <vector>

#include "grtx/modules/cache/l2_slice_if.h"
#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/noc/crossbar_if.h"
#include "grtx/modules/simt/work_distributor_if.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/gpu_parts.h"
#include "grtx/rtl_tlm/gpu/sm.h"
#include "grtx/traces/header.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

/// How the model is built and stepped. None of these may change a result, except user-supplied parts.
struct BuildOptions {
  std::uint64_t construction_order = 0;  ///< see construct()
  bool idle_skip = true;                 ///< jump over cycles in which nothing happens
  bool run_ahead = true;                 ///< tick without the kernel while it has nothing else to do (run_for)
  std::uint64_t memory_bytes = 0;        ///< memory for later launches, if more than for the first
  bool keep_data = false;  ///< write-backs carry what the memory holds (its transport_dbg) instead of zeros
  std::uint64_t base = 0;  ///< where the GPU's memory begins on the bus; a multiple of 4096
  GpuParts parts;          ///< factories of user-supplied units, which may change results
};

/// The address map of a run. eviction_entries: the most that any ray of the trace has in its eviction buffer.
modules::MemoryMapConfig memory_map_config(const GpuConfig& config, const traces::Header& header,
                                           std::uint64_t eviction_entries);

/// Bytes of memory that a trace needs.
std::uint64_t memory_bytes(const GpuConfig& config, const traces::Reader& reader);

class Gpu final : public sc_core::sc_module {
 public:
  /// source must outlive the GPU; the header is copied. eviction_entries: see memory_map_config().
  Gpu(const sc_core::sc_module_name& name, const GpuConfig& config, const traces::Header& header,
      std::uint64_t eviction_entries, modules::GroupSource& source, const BuildOptions& build);

  /// One per L2 slice; bind each to a base-protocol target, or let a MemorySystem do so. Addresses are global.
  sc_core::sc_vector<::tlm::tlm_initiator_socket<32>> dram;

  modules::ClockDomain& core() { return core_; }
  const modules::ClockDomain& core() const { return core_; }
  const modules::MemoryMap& map() const { return map_; }
  /// Bytes of memory that all launches need.
  std::uint64_t memory_bytes() const { return std::max(memory_bytes_, map_.bytes()); }
  /// Where its memory begins on the bus (BuildOptions).
  std::uint64_t base() const { return base_; }
  const GpuConfig& config() const { return config_; }
  const std::vector<std::unique_ptr<Sm>>& sms() const { return sms_; }
  const std::vector<std::unique_ptr<modules::L2SliceModule>>& slices() const { return slices_; }
  const modules::CrossbarModule& crossbar() const { return *crossbar_; }
  const modules::WorkDistributorModule& distributor() const { return *distributor_; }
  modules::WorkDistributorModule& distributor() { return *distributor_; }
  /// Calls f(link) for each link outside the SMs.
  template <typename F>
  void for_each_link(F&& f) const {
    const auto each = [&f](const auto& links) {
      for (const auto& link : links) f(*link);
    };
    each(launches_);
    each(ends_);
    each(sm_requests_);
    each(sm_responses_);
    each(slice_requests_);
    each(slice_responses_);
  }

  /// True once the last warp has ended (in distributor().end_cycle()); prefetches and write-backs may still be under
  /// way.
  bool finished() const { return distributor_->finished(); }
  /// True if nothing is inside, links included.
  bool idle() const;
  /// Begins another launch, of the groups that the source then has: resets all units and makes this cycle 0; caches
  /// keep their contents if `caches` is warm. Work in flight is dropped; no request may be in flight at the memory.
  /// header: for the same hardware (same_hardware()); it is copied. The memory has its own restart().
  void restart(const traces::Header& header, std::uint64_t eviction_entries, modules::Caches caches);
  /// Until restart() no slice sends anything more to the memory, so that a launch under way can be abandoned.
  void hold_requests() {
    for (const auto& slice : slices_) slice->hold_requests();
  }
  /// Write and read the cache contents, for a warm run in another process. save(): when idle(). load(): before the
  /// first launch, on the same machine for the same hardware (hardware_of()). The memory has its own.
  void save(StateWriter& state) const;
  void load(StateReader& state);
  /// Grows whenever the GPU does anything; for a watchdog.
  std::uint64_t progress() const;
  /// The last core cycle for which anything is scheduled, as far as is known now, for the watchdog.
  Cycle awaited() const { return core_.latest(); }
  std::vector<modules::Inventory> inventory() const;
  void dump_state(std::ostream& out) const;

 private:
  template <typename T>
  using LinkPointer = std::unique_ptr<modules::Link<T>>;

  void build_units(modules::GroupSource& source, const BuildOptions& build);
  void bind_links();

  GpuConfig config_;
  traces::Header header_;
  modules::MemoryMap map_;
  std::uint64_t memory_bytes_;
  std::uint64_t base_;
  modules::ClockDomain core_;
  std::vector<LinkPointer<modules::LaunchWarp>> launches_;             ///< by SM
  std::vector<LinkPointer<modules::WarpEnded>> ends_;                  ///< by SM
  std::vector<LinkPointer<modules::MemoryRequest>> sm_requests_;       ///< by SM
  std::vector<LinkPointer<modules::MemoryResponse>> sm_responses_;     ///< by SM
  std::vector<LinkPointer<modules::MemoryRequest>> slice_requests_;    ///< by slice
  std::vector<LinkPointer<modules::MemoryResponse>> slice_responses_;  ///< by slice
  std::unique_ptr<modules::WorkDistributorModule> distributor_;
  std::vector<std::unique_ptr<Sm>> sms_;
  std::unique_ptr<modules::CrossbarModule> crossbar_;
  std::vector<std::unique_ptr<modules::L2SliceModule>> slices_;
};

/// Text that names what a trace needs in hardware: structure, k, checkpointing, warp size, node layout, levels, width.
std::string hardware_of(const traces::Header& header);
/// Whether traces with these headers need the same hardware: they may only differ in what is in memory.
bool same_hardware(const traces::Header& a, const traces::Header& b);
/// Names the scene behind a trace's addresses, from its inputs: hashes of the scene's files, and how its structure was
/// built. Caches warm with another scene would give false hits. "": the inputs do not tell.
std::string addressed_scene(const traces::Header& header);

/// Pauses the kernel when the last warp has ended, for a program that steps it with run_for().
class PauseAtEnd final : public sc_core::sc_module {
 public:
  using SC_CURRENT_USER_MODULE = PauseAtEnd;  // SC_HAS_PROCESS, which SystemC 3 deprecates
  PauseAtEnd(const sc_core::sc_module_name& name, const Gpu& gpu);

 private:
  void pause() { sc_core::sc_pause(); }
};

/// Runs the kernel for `cycles` core cycles; clocks may run ahead of it. Throws Error if a unit has called sc_stop().
void run_for(Gpu& gpu, Cycle cycles);

}  // namespace grtx::sim
