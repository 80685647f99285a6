// SPDX-License-Identifier: Apache-2.0
// One slice of the shared L2: sectored, write-back, write-allocate without fetch, non-blocking, with a TLM-2.0 AT
// socket to its DRAM channel. Paper Table I (4 MB, 16-way, 165 cycles); MSHRs and queues from Vulkan-Sim's GPGPU-Sim.
// Costs one tag probe per access; sleeps when only DRAM requests are outstanding.
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <systemc>
#include <tlm>
#include <vector>

#include "grtx/base/state_bytes.h"
#include "grtx/modules/cache/cache_counters.h"
#include "grtx/modules/cache/cache_state.h"
#include "grtx/modules/cache/decide/dilated_fills.h"
#include "grtx/modules/cache/decide/mshr_table.h"
#include "grtx/modules/cache/decide/sector_cache_tags.h"
#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/messages/address_interleave.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/sampling.h"
#include "grtx/modules/messages/touch_if.h"
#include "grtx/modules/tlm/at_initiator.h"

namespace grtx::modules {

struct L2Counters;

/// A slice as the GPU sees it: every request gets exactly one response with its tag, client and SM, in any order.
class L2SliceModule : public ClockedModule {
 public:
  LinkIn<MemoryRequest> request{"request"};
  LinkOut<MemoryResponse> response{"response"};
  /// To the DRAM channel, with global addresses.
  virtual ::tlm::tlm_initiator_socket<32>& memory_socket() = 0;

  virtual L2Counters counters() const = 0;
  /// No request in flight. Dirty sectors may remain in the cache: they are written back only on eviction.
  virtual bool idle() const = 0;
  virtual std::uint64_t dirty_sectors() const = 0;
  virtual Inventory inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;
  /// Save and restore what restart(Caches::warm) keeps, for a run that another process continues. save() needs an idle
  /// slice, load() a newly constructed one.
  virtual void save(StateWriter&) const { refuse_state(*this); }
  virtual void load(StateReader&) { refuse_state(*this); }

 protected:
  using ClockedModule::ClockedModule;
};

/// Why the access at the head of the slice's queue, or a fill, had to wait in this cycle.
enum class L2Stall : std::uint8_t { reply_queue, mshr_full, merges_full, dram_queue, fill };
constexpr auto enum_names(L2Stall) {
  return names_in_order<L2Stall>({"reply_queue", "mshr_full", "merges_full", "dram_queue", "fill"});
}

/// Counters of one slice; the GPU sums them over its slices.
struct L2Counters : CacheRegions {
  std::array<std::uint64_t, kCountOf<L2Stall>> stalls{};
  std::uint64_t requests_in = 0;
  std::uint64_t replies_out = 0;
  std::uint64_t dram_reads = 0;                              ///< sectors
  std::uint64_t dram_writes = 0;                             ///< dirty sectors written back
  std::array<std::uint64_t, kRegionCount> dram_reads_of{};   ///< dram_reads per region of the read
  std::array<std::uint64_t, kRegionCount> dram_writes_of{};  ///< dram_writes per region that last dirtied the line
  std::uint64_t evictions = 0;                               ///< lines
  std::uint64_t mshr_cycles = 0;
  Distribution miss_latency;  ///< from MSHR allocation to fill, core cycles
  OwnCounts own;              ///< extra counters of a user-supplied slice

  std::uint64_t accesses() const;
  static const CounterTable<L2Counters>& table();
  L2Counters& operator+=(const L2Counters& other) {
    table().add(*this, other);
    return *this;
  }
  /// Appends them as prefix + ".name".
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};

class L2Slice final : public L2SliceModule, public touch_if {
 public:
  struct Config {
    unsigned slice = 0;  ///< number of this slice; set by the assembly
    AddressInterleave interleave{};
    Sampling sampling{};                                           ///< set by the assembly
    SectorCacheTags::Geometry geometry{1024 * 1024, 128, 32, 16};  ///< of one slice
    unsigned latency = 165;  ///< tags are probed after it, so misses pay it too, as with GPGPU-Sim's ROP delay
    unsigned queue = 64;
    unsigned mshr_entries = 192;
    unsigned mshr_merges = 4;
    unsigned reply_queue = 64;
    unsigned dram_queue = 64;
    bool perfect = false;  ///< every access hits; DRAM is never accessed
    /// All but the size, which the GPU declares for all slices together.
    void parameters(ParameterList& list) {
      geometry.shape_parameters(list);
      list.add("latency", latency, {1, kMaxLatency}, "cycles",
               "from request at the slice to the reply of a hit; misses pay it too", kTable1);
      list.add("queue", queue, {1, kMaxEntries}, "requests", "accesses waiting at the tags", kVulkanSim);
      list.add("mshr_entries", mshr_entries, {1, kMaxEntries}, "sectors", "sectors outstanding of a slice", kVulkanSim);
      list.add("mshr_merges", mshr_merges, {1, kMaxEntries}, "requests", "requests of an MSHR, the first included",
               kVulkanSim);
      list.add("reply_queue", reply_queue, {1, kMaxEntries}, "replies", "waiting for the crossbar", kVulkanSim);
      list.add("dram_queue", dram_queue, {1, kMaxEntries}, "requests", "reads and write-backs waiting for DRAM",
               kVulkanSim);
      list.add("perfect", perfect, "every access hits (limit study)", kOurs);
      list.rule(
          "bytes", [this] { return geometry.sets() >= 1; },
          "a slice (l2.bytes / l2.slices) must hold at least l2.ways lines of l2.line_bytes");
      list.rule(
          "interleave_bytes", [this] { return geometry.line_bytes <= interleave.bytes; },
          "must not be smaller than l2.line_bytes");
      list.rule(
          "reply_queue", [this] { return reply_queue >= mshr_merges; },
          "must hold the replies of an MSHR (l2.mshr_merges)");
      list.rule(
          "dram_queue", [this] { return dram_queue >= geometry.sectors(); },
          "must hold the write-back of a line (l2.line_bytes / 32)");
    }
  };

  /// clock: core domain. Throws Error for an impossible configuration.
  L2Slice(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock);

  AtInitiator dram;
  ::tlm::tlm_initiator_socket<32>& memory_socket() override { return dram.socket; }

  /// All sectors of `access` must belong to this slice.
  Touched touch(const Touch& access) override;
  Inventory inventory() const override;
  void statistics(StatisticList& list, const std::string& prefix) const { counters_.describe(list, prefix); }
  L2Counters counters() const override { return counters_; }
  const L2Counters& raw_counters() const { return counters_; }  ///< the same, without a copy
  bool idle() const override;
  std::size_t mshr_used() const { return mshrs_.used(); }         ///< entries occupied now
  std::size_t accesses_queued() const { return pipe_.size(); }    ///< in the pipeline or waiting at the tags
  std::size_t replies_queued() const { return replies_.size(); }  ///< waiting for the crossbar
  std::size_t dram_queued() const { return dram_queue_.size(); }  ///< waiting for the DRAM
  std::uint64_t dirty_sectors() const override { return tags_.count_dirty(); }
  void dump_state(std::ostream& out) const override;
  void save(StateWriter& state) const override;
  void load(StateReader& state) override;
  const Config& config() const { return config_; }

 private:
  static constexpr std::uint32_t kWriteBack = ~std::uint32_t{0};  ///< context of DRAM requests without an MSHR

  struct Access {
    MemoryRequest request;
    Cycle due = 0;
  };
  struct DramRequest {
    std::uint64_t address = 0;
    std::uint32_t context = 0;
    RequestOrigin origin;
    bool write = false;
  };

  void end_of_elaboration() override;
  Cycle tick(Cycle now) override;
  void restart(Caches caches) override;
  bool work_at(Cycle now) const;
  void take_request(Cycle now);
  void take_completion(Cycle now);
  bool fill(Cycle now, std::uint32_t mshr);
  bool install(std::uint64_t local);
  void look_up(Cycle now);
  bool read(Cycle now, const MemoryRequest& access);
  bool write(const MemoryRequest& access);
  bool stall(L2Stall reason);
  void prefetch_host(Cycle now) const;
  bool room_for_victim(std::uint64_t local) const;
  SectorCacheTags::Slot allocate(std::uint64_t local);
  Touched touch_line(std::uint64_t local, std::uint8_t sectors, const Touch& access);
  bool sampled() const { return config_.sampling.on(); }
  void write_back(const SectorCacheTags::Victim& victim, Region region);
  void write_back_late();
  void reply(const MemoryRequest& access);
  void send_dram(Cycle now);
  void send_reply(Cycle now);
  Cycle next_due(Cycle now) const;
  Cycle next_arrival() const;
  void count_mshr_cycles(Cycle now);

  Config config_;
  LinkReader<MemoryRequest> in_;
  LinkWriter<MemoryResponse> out_;
  SectorCacheTags tags_;            ///< by slice-local address
  std::vector<Region> written_by_;  ///< [slot] region that last dirtied the line
  MshrTable mshrs_;                 ///< by global sector address
  DilatedFills fills_;
  RingQueue<Access> pipe_;
  RingQueue<MemoryResponse> replies_;
  RingQueue<DramRequest> dram_queue_;
  struct Late {
    SectorCacheTags::Victim victim;
    Region region{};
  };
  std::vector<Late> late_;        ///< sampled run: evicted dirty lines that wait for dram_queue_
  std::uint64_t left_dirty_ = 0;  ///< sampled run: dirty lines evicted; one in `stride` is written back in time
  Cycle due_ = kNever;
  Cycle mshr_counted_ = 0;
  L2Counters counters_;
};

}  // namespace grtx::modules
