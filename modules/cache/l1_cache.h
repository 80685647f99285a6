// SPDX-License-Identifier: Apache-2.0
// L1 data cache of an SM: sectored, banked, non-blocking with MSHRs. Write-through without allocation; optionally
// write-back for data private to one ray or warp (write_policy.h).
// Paper Table I (128 KB, 128 B lines, 256-way, LRU, 20 cycles); MSHRs and queues as in Vulkan-Sim's GPGPU-Sim.
// Costs one tag probe per accepted request; sleeps when nothing is in flight.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <systemc>
#include <vector>

#include "grtx/base/state_bytes.h"
#include "grtx/modules/cache/cache_counters.h"
#include "grtx/modules/cache/cache_state.h"
#include "grtx/modules/cache/decide/dilated_fills.h"
#include "grtx/modules/cache/decide/mshr_table.h"
#include "grtx/modules/cache/decide/sector_cache_tags.h"
#include "grtx/modules/cache/decide/write_policy.h"
#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/kernel/waiting_links.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/sampling.h"
#include "grtx/modules/messages/touch_if.h"

namespace grtx::modules {

struct L1Counters;

/// An L1 as the SM sees it: every request gets exactly one response with its tag, in any order. An implementation that
/// needs no clock may ignore it.
class L1CacheModule : public ClockedModule {
 public:
  sc_core::sc_vector<LinkIn<MemoryRequest>> request;     ///< [client], consumed here
  sc_core::sc_vector<LinkOut<MemoryResponse>> response;  ///< [client], produced here
  LinkOut<MemoryRequest> to_memory{"to_memory"};         ///< misses and writes, with client and SM filled in
  LinkIn<MemoryResponse> from_memory{"from_memory"};     ///< fills and write acknowledgements
  TouchPort<touch_if> touch_memory{"touch_memory"};      ///< functional misses of a sampled run

  /// Counts so far.
  virtual L1Counters counters() const = 0;
  /// Nothing inside and nothing waiting at its ports.
  virtual bool idle() const = 0;
  virtual Inventory inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;
  /// Save and restore what restart(Caches::warm) keeps, for a run that another process continues. save() needs an idle
  /// cache, load() a newly constructed one.
  virtual void save(StateWriter&) const { refuse_state(*this); }
  virtual void load(StateReader&) { refuse_state(*this); }

 protected:
  L1CacheModule(const char* name, ClockDomain& clock, unsigned clients) = delete;  ///< see ClockedModule
  L1CacheModule(const sc_core::sc_module_name& name, ClockDomain& clock, unsigned clients)
      : ClockedModule(name, clock), request("request", clients), response("response", clients) {}
};

/// Why the request at the head of a client's port was not accepted in this cycle.
enum class L1Stall : std::uint8_t { response_port, bank_conflict, mshr_full, merges_full, miss_queue_full };
constexpr auto enum_names(L1Stall) {
  return names_in_order<L1Stall>({"response_port", "bank_conflict", "mshr_full", "merges_full", "miss_queue_full"});
}

/// Counters of one cache; the GPU sums them over its SMs. Demand and prefetch accesses are counted separately.
struct L1Counters : CacheRegions {
  std::array<std::uint64_t, kCountOf<L1Stall>> stalls{};  ///< client-cycles
  /// prefetches = redundant + fetched; fetched = useful + late + unused, once nothing is pending.
  std::uint64_t prefetches = 0, prefetches_redundant = 0, prefetches_fetched = 0;
  std::uint64_t prefetches_useful = 0, prefetches_late = 0, prefetches_unused = 0;
  std::uint64_t responses = 0, fills = 0, fills_bypassed = 0, evictions = 0;
  std::uint64_t kept_writes = 0, rewrites = 0, write_backs = 0;
  std::uint64_t sent_reads = 0, sent_writes = 0;  ///< to the crossbar
  std::uint64_t mshr_cycles = 0;
  Distribution miss_latency;  ///< from MSHR allocation to fill, core cycles
  OwnCounts own;              ///< extra counters of a user-supplied cache

  /// Demand and prefetch requests accepted.
  std::uint64_t accesses() const;
  static const CounterTable<L1Counters>& table();
  L1Counters& operator+=(const L1Counters& other) {
    table().add(*this, other);
    return *this;
  }
  /// Appends them as prefix + ".name".
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};

class L1Cache final : public L1CacheModule, public touch_if {
 public:
  struct Config {
    unsigned clients = 2;          ///< request/response port pairs; set by the assembly
    std::uint8_t sm = 0;           ///< SM number that requests carry into the crossbar; set by the assembly
    std::vector<unsigned> widths;  ///< [client] port width in sectors per cycle, 1 if absent; set by the assembly
    Sampling sampling{};           ///< set by the assembly
    SectorCacheTags::Geometry geometry{};
    unsigned latency = 20;
    unsigned tag_latency = 1;
    unsigned banks = 4;
    unsigned mshr_entries = 256;
    unsigned mshr_merges = 8;
    unsigned miss_queue = 16;
    PrivateWrites private_writes;
    unsigned write_back_buffer = 16;  ///< lines; unused unless private_writes is write_back
    bool rotating_priority = true;    ///< start after the client that last won first; false: always start at client 0
    bool perfect = false;             ///< every access hits; nothing is sent to the L2
    void parameters(ParameterList& list) {
      list.add("bytes", geometry.bytes, {32, 1 << 26}, "B", "size of the L1 data cache", kTable1);
      geometry.shape_parameters(list);
      list.add("latency", latency, {1, kMaxLatency}, "cycles", "from request to response of a hit", kTable1);
      list.add("tag_latency", tag_latency, {1, kMaxLatency}, "cycles", "from request to a miss leaving the cache",
               kOurs);
      list.add("banks", banks, {1, 64}, "banks", "sector-interleaved banks, one access a cycle each", kVulkanSim);
      list.add("mshr_entries", mshr_entries, {1, kMaxEntries}, "sectors", "sectors outstanding", kVulkanSim);
      list.add("mshr_merges", mshr_merges, {1, kMaxEntries}, "requests", "requests of an MSHR, the first included",
               kVulkanSim);
      list.add("miss_queue", miss_queue, {1, kMaxEntries}, "requests", "misses and writes waiting for the crossbar",
               kVulkanSim);
      private_writes.parameters(list);
      list.add("write_back_buffer", write_back_buffer, {1, kMaxEntries}, "lines",
               "dirty lines that have left and wait for the crossbar; with private_writes = write_back",
               from_public("XiangShan: 18 entries of a line beside 16 misses"));
      list.add("rotating_priority", rotating_priority, "rotating priority of the clients; else node fetches first",
               kOurs);
      list.add("perfect", perfect, "every access hits (limit study)", kOurs);
      list.rule(
          "bytes", [this] { return geometry.sets() >= 1; }, "must hold at least l1.ways lines of l1.line_bytes");
    }
  };

  /// clock: core domain. Throws Error for an impossible configuration.
  L1Cache(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock);

  Touched touch(const Touch& access) override;
  Inventory inventory() const override;
  void statistics(StatisticList& list, const std::string& prefix) const;
  /// Counters so far. Unused prefetches include sectors still resident; mshr_cycles is current up to the last change.
  L1Counters counters() const override;
  /// Sampled run: sectors that demand reads missed.
  const TimedShare& timed_misses() const { return timed_misses_; }
  bool idle() const override;
  std::size_t mshr_used() const { return mshrs_.used(); }           ///< entries occupied now
  std::size_t misses_queued() const { return miss_queue_.size(); }  ///< misses and writes waiting for the crossbar
  std::uint64_t dirty_at_start() const { return dirty_at_start_; }  ///< dirty sectors left by the previous launch
  /// Without sampling = dirty_at_start + kept_writes - rewrites - write_backs.
  std::uint64_t dirty_sectors() const { return tags_.count_dirty(); }
  std::uint64_t writes_pending() const { return writes_pending_; }  ///< not acknowledged yet
  const L1Counters& raw_counters() const { return counters_; }      ///< without the resident unused prefetches
  void dump_state(std::ostream& out) const override;
  void save(StateWriter& state) const override;
  void load(StateReader& state) override;
  const Config& config() const { return config_; }

 private:
  struct Pending {
    MemoryResponse response;
    Cycle due = 0;  ///< earliest cycle to enter the response link
  };
  struct Miss {
    MemoryRequest request;
    Cycle due = 0;
    bool line_gone = false;  ///< last sector of its line in the write-back buffer
  };
  /// Why a request was refused, and version_ at that time: while version_ is unchanged it would be refused again.
  struct Refusal {
    std::uint64_t at = kNever;
    L1Stall reason{};
  };
  struct Client {
    LinkReader<MemoryRequest> request;
    LinkWriter<MemoryResponse> response;
    RingQueue<Pending> hits;   ///< the hit pipeline
    RingQueue<Pending> fills;  ///< responses to fills and write acknowledgements
    unsigned width = 1;        ///< sectors per cycle
    unsigned hit_latency = 0;  ///< cycles from acceptance until a hit enters the response link
    Refusal refused;           ///< last refusal of the head request
  };

  void end_of_elaboration() override;
  Cycle tick(Cycle now) override;
  void restart(Caches caches) override;
  void take_response(Cycle now);
  void fill(Cycle now, std::uint32_t mshr, std::uint64_t address);
  void install(Cycle now, std::uint32_t mshr, std::uint64_t address);
  void take_requests(Cycle now);
  void take_from(Cycle now, unsigned client, bool& won);
  bool accept(Cycle now, Client& client, const MemoryRequest& access);
  bool accept_read(Cycle now, Client& client, const MemoryRequest& access);
  bool accept_write(Cycle now, Client& client, const MemoryRequest& access);
  Touched touch_write(std::uint64_t line, std::uint8_t sectors, const Touch& access);
  Touched touch_read(std::uint64_t line, std::uint8_t sectors, const Touch& access);
  SectorCacheTags::Slot touch_allocate(std::uint64_t line, Cycle at);
  void push_dirty(Cycle now, const SectorCacheTags::Victim& victim, Region region);
  void push_late(Cycle now);
  bool stall(L1Stall reason);
  bool refuse(Client& client, L1Stall reason);
  bool room_to_send(std::size_t entries) const {
    return miss_queue_.size() - leaving_sectors_ + entries <= config_.miss_queue;
  }
  bool room_for_victim(std::uint64_t address) const {
    if (sampled()) return late_.empty();
    return leaving_lines_ < config_.write_back_buffer || tags_.victim(address).dirty == 0;
  }
  SectorCacheTags::Slot allocate(Cycle now, std::uint64_t address) {
    return allocate(now, address, tags_.victim_slot(address));
  }
  SectorCacheTags::Slot allocate(Cycle now, std::uint64_t address, SectorCacheTags::Slot place);
  void answer_hit(Cycle now, Client& client, const MemoryRequest& access);
  void reference(SectorCacheTags::Slot slot, std::uint8_t sector);
  void send_miss(Cycle now);
  void send_responses(Cycle now);
  void send_response(Cycle now, std::size_t client);
  /// A response was added to the client's queues, to be sent in cycle `due` or later.
  void respond_at(Cycle due, std::size_t client) {
    response_due_[client] = std::min(response_due_[client], due);
    next_response_ = std::min(next_response_, due);
  }
  bool sampled() const { return config_.sampling.on(); }
  Cycle next_due(Cycle now) const;
  void count_mshr_cycles(Cycle now);

  Config config_;
  LinkWriter<MemoryRequest> down_;
  LinkReader<MemoryResponse> up_;
  touch_if* touched_ = nullptr;  ///< null if the run is not sampled
  std::vector<Client> clients_;
  WaitingLinks waiting_;             ///< clients with waiting requests
  std::vector<Cycle> response_due_;  ///< [client] cycle in which its next response may enter the link, or kNever
  SectorCacheTags tags_;
  MshrTable mshrs_;
  DilatedFills fills_;
  struct Late {
    SectorCacheTags::Victim victim;
    Region region{};
  };
  std::vector<Late> late_;        ///< sampled run: evicted dirty lines that wait for the write-back buffer
  TimedShare timed_misses_;       ///< sampled run
  std::uint64_t left_dirty_ = 0;  ///< sampled run: dirty lines evicted; one in `stride` is written back in time
  bool writes_back_;
  std::vector<Region> written_by_;  ///< [slot] region that last dirtied the line
  /// Misses, writes and write-back sectors, in FIFO order: a read never overtakes an earlier write of its data.
  RingQueue<Miss> miss_queue_;
  std::size_t leaving_sectors_ = 0;  ///< entries of miss_queue_ that occupy the write-back buffer instead
  unsigned leaving_lines_ = 0;       ///< write-back buffer lines occupied
  unsigned bank_mask_;               ///< banks - 1 if a power of two, else 0
  unsigned first_client_ = 0;
  std::uint64_t banks_taken_ = 0;  ///< bit mask of the banks used in this cycle
  std::uint64_t writes_pending_ = 0;
  std::uint64_t version_ = 0;     ///< incremented when tags, MSHRs or the miss queue change (see Refusal)
  Cycle next_request_ = kNever;   ///< next cycle with a request at the head of a client's port
  Cycle next_response_ = kNever;  ///< the earliest of response_due_
  Cycle mshr_counted_ = 0;
  std::uint64_t dirty_at_start_ = 0;
  L1Counters counters_;
};

}  // namespace grtx::modules
