// The GPU: work distributor, SMs, crossbar and L2 slices in one core clock domain, with a TLM-2.0 AT socket a slice
// towards DRAM. Paper: Table I. Cost: the sum of its parts.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <memory>
#include <systemc>
#include <tlm>
#include <vector>

#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/noc/crossbar.h"
#include "grtx/modules/simt/work_distributor.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/gpu/gpu_parts.h"
#include "grtx/rtl_tlm/gpu/sm.h"
#include "grtx/traces/header.h"
#include "grtx/traces/reader.h"

namespace grtx::sim {

/// How the model is built and stepped. None of these may change a result, parts of others aside.
struct BuildOptions {
  std::uint64_t construction_order = 0;  ///< see construct()
  bool idle_skip = true;                 ///< jump over cycles in which nothing happens
  bool run_ahead = true;                 ///< tick without the kernel while it has nothing else to do (run_for)
  unsigned threads = 1;                  ///< that share the SMs; more than one needs run_ahead and the built-in memory
  std::function<bool()> crowded;         ///< for tests: ClockThreads::judge_by(), and as many threads as are asked for
  std::uint64_t memory_bytes = 0;        ///< that launches to come need, if more than the first
  GpuParts parts;                        ///< who makes the units; units of others may change results
};

/// The address map of a run. eviction_entries: most entries that a ray of the trace has in its eviction buffer.
modules::MemoryMapConfig memory_map_config(const GpuConfig& config, const traces::Header& header,
                                           std::uint64_t eviction_entries);

/// Size of the memory that a trace needs.
std::uint64_t memory_bytes(const GpuConfig& config, const traces::Reader& reader);

class SmThreads;

class Gpu final : public sc_core::sc_module {
 public:
  /// source must outlive the GPU; the header is copied. eviction_entries: most entries that a ray of the trace has in
  /// its eviction buffer.
  Gpu(const sc_core::sc_module_name& name, const GpuConfig& config, const traces::Header& header,
      std::uint64_t eviction_entries, modules::GroupSource& source, const BuildOptions& build);
  ~Gpu() override;

  /// One a slice; bind each to a base-protocol target, or leave it to a MemorySystem. Addresses are global.
  sc_core::sc_vector<::tlm::tlm_initiator_socket<32>> dram;

  modules::ClockDomain& core() { return core_; }
  const modules::ClockDomain& core() const { return core_; }
  const modules::MemoryMap& map() const { return map_; }
  /// Size of the memory.
  std::uint64_t memory_bytes() const { return std::max(memory_bytes_, map_.bytes()); }
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

  /// The last warp has ended: the cycle is distributor().end_cycle(). Prefetches and write-backs may still be under
  /// way.
  bool finished() const { return distributor_->finished(); }
  /// Nothing inside, links included.
  bool idle() const;
  /// Another launch, of what the source has then: all units are as built, but for what the caches hold, and cycle 0 is
  /// now. Only when idle(), on one thread. header: of the same hardware (same_hardware()); it is copied. The memory
  /// has its own restart().
  void restart(const traces::Header& header, std::uint64_t eviction_entries, modules::Caches caches);
  /// What restart() keeps with warm caches, for a run in another process; when idle(). load(): before the first launch,
  /// on the same machine for the same hardware (hardware_of()). The memory has its own.
  void save(StateWriter& state) const;
  void load(StateReader& state);
  /// Other programs took the host's cores from its threads: one stepped all SMs for a while.
  bool left_to_one_thread() const;
  /// Grows with all that the GPU does; for a watchdog.
  std::uint64_t progress() const;
  /// The last core cycle for which anything is scheduled, as far as is known now, for the watchdog.
  Cycle awaited() const;
  std::vector<modules::Inventory> inventory() const;
  void dump_state(std::ostream& out) const;

 private:
  template <typename T>
  using LinkPointer = std::unique_ptr<modules::Link<T>>;

  GpuConfig config_;
  traces::Header header_;
  modules::MemoryMap map_;
  std::uint64_t memory_bytes_;
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
  std::unique_ptr<SmThreads> threads_;  ///< none: all is on the kernel's thread. Ends before the units do.
};

/// What a trace wants built, as text.
std::string hardware_of(const traces::Header& header);
/// Whether traces with these headers run on the same machine: they differ in what is in memory alone, not in what is
/// built.
bool same_hardware(const traces::Header& a, const traces::Header& b);
/// What the addresses of a trace stand for, as its inputs say: the files of its scene, and how its structure was built.
/// Caches that hold another's would hit where nothing of this one was read. "": they do not say.
std::string addressed_scene(const traces::Header& header);

/// Pauses the kernel in the cycle in which the last warp has ended: for a program that steps it (run_for()).
class PauseAtEnd final : public sc_core::sc_module {
 public:
  using SC_CURRENT_USER_MODULE = PauseAtEnd;  // SC_HAS_PROCESS, which SystemC 3 deprecates
  PauseAtEnd(const sc_core::sc_module_name& name, const Gpu& gpu);

 private:
  void pause() { sc_core::sc_pause(); }
};

/// Steps the kernel by so many core cycles, with the clocks ahead of it where they may be.
void run_for(Gpu& gpu, Cycle cycles);

}  // namespace grtx::sim
