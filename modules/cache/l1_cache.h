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
#include "grtx/modules/cache/cache_state.h"
#include "grtx/modules/cache/decide/mshr_table.h"
#include "grtx/modules/cache/decide/sector_cache_tags.h"
#include "grtx/modules/cache/decide/write_policy.h"
#include "grtx/modules/cache/l1_cache_if.h"
#include "grtx/modules/cache/request_stages.h"
#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/kernel/waiting_links.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

class L1Cache final : public L1CacheModule {
 public:
  using Config = L1CacheConfig;

  /// clock: core domain. Throws Error for an impossible configuration.
  L1Cache(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock);

  Inventory inventory() const override;
  void statistics(StatisticList& list, const std::string& prefix) const;
  /// Counters so far. Unused prefetches include sectors still resident; mshr_cycles is current up to the last change.
  L1Counters counters() const override;
  bool idle() const override;
  std::size_t mshr_used() const { return mshrs_.used(); }           ///< entries occupied now
  std::size_t misses_queued() const { return miss_queue_.size(); }  ///< misses and writes waiting for the crossbar
  std::uint64_t dirty_at_start() const { return dirty_at_start_; }  ///< dirty sectors left by the previous launch
  /// = dirty_at_start + kept_writes - rewrites - write_backs.
  std::uint64_t dirty_sectors() const { return tags_.count_dirty(); }
  std::uint64_t writes_pending() const { return writes_pending_; }  ///< not acknowledged yet
  const L1Counters& raw_counters() const { return counters_; }      ///< without the resident unused prefetches
  void dump_state(std::ostream& out) const override;
  void preload(std::uint64_t address) override;
  void save(StateWriter& state) const override;
  void load(StateReader& state) override;
  ReadAtOnce read_at_once(Cycle now, const MemoryRequest& sector) override;
  const Config& config() const { return config_; }
  /// From now on it is told of reads; nullptr: of none, the default. Call while idle.
  void observe(RequestStages* stages) { stages_ = stages; }

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
    RingQueue<Pending> hits;                      ///< the hit pipeline
    RingQueue<Pending> fills;                     ///< responses to fills and write acknowledgements
    RingQueue<ServedRead> hit_reads, fill_reads;  ///< beside hits and fills, if observed
    unsigned width = 1;                           ///< sectors per cycle
    unsigned hit_places = 0;                      ///< hits in the pipeline at which the request port is blocked
    unsigned hit_latency = 0;                     ///< cycles from acceptance until a hit enters the response link
    Refusal refused;                              ///< last refusal of the head request
  };

  void end_of_elaboration() override;
  Cycle tick(Cycle now) override;
  void restart(Caches caches) override;
  // The work of a tick; kObserved: reads are reported to stages_. What each access passes is compiled for both, so that
  // a run without an observer does not ask for one.
  template <bool kObserved>
  Cycle work(Cycle now);
  void take_response(Cycle now);
  void fill(Cycle now, std::uint32_t mshr, std::uint64_t address);
  void install(Cycle now, std::uint32_t mshr, std::uint64_t address);
  template <bool kObserved>
  void take_requests(Cycle now);
  template <bool kObserved>
  void take_from(Cycle now, unsigned client, bool& won);
  // access: as at the port; who asks is `port`, whatever the request says.
  template <bool kObserved>
  bool accept(Cycle now, unsigned port, const MemoryRequest& access);
  void count_hit(unsigned port, const MemoryRequest& access, SectorCacheTags::Slot slot, std::uint8_t sector,
                 bool present);
  template <bool kObserved>
  bool accept_read(Cycle now, unsigned port, const MemoryRequest& access);
  bool accept_miss(Cycle now, unsigned port, const MemoryRequest& access, SectorCacheTags::Slot slot);
  bool accept_write(Cycle now, unsigned port, const MemoryRequest& access);
  MemoryRequest from_port(unsigned port, const MemoryRequest& access) const {
    MemoryRequest from = access;
    from.client = static_cast<std::uint8_t>(port);
    from.sm = config_.sm;
    return from;
  }
  void push_dirty(Cycle now, const SectorCacheTags::Victim& victim, Region region);
  bool stall(L1Stall reason);
  bool refuse(Client& client, L1Stall reason);
  bool room_to_send(std::size_t entries) const {
    return miss_queue_.size() - leaving_sectors_ + entries <= config_.miss_queue;
  }
  // access: with client and SM, as from_port() has it.
  bool room_for_victim(const MemoryRequest& access) const {
    return leaving_lines_ < config_.write_back_buffer || tags_.victim(access.address, access).dirty == 0;
  }
  SectorCacheTags::Slot allocate(Cycle now, const MemoryRequest& access) {
    return allocate(now, access, tags_.victim_slot(access.address, access));
  }
  SectorCacheTags::Slot allocate(Cycle now, const MemoryRequest& access, SectorCacheTags::Slot place);
  template <bool kObserved>
  void answer_hit(Cycle now, unsigned port, const MemoryRequest& access);
  void reference(SectorCacheTags::Slot slot, std::uint8_t sector);
  void send_miss(Cycle now);
  template <bool kObserved>
  void send_responses(Cycle now);
  template <bool kObserved>
  Cycle send_response(Cycle now, Client& client);
  void report(Client& client, bool hit, Cycle now);
  /// A response was added to the client's queues, to be sent in cycle `due` or later.
  void respond_at(Cycle due, std::size_t client) {
    response_due_[client] = std::min(response_due_[client], due);
    next_response_ = std::min(next_response_, due);
  }
  Cycle next_due(Cycle now) const;
  void count_mshr_cycles(Cycle now);

  Config config_;
  LinkWriter<MemoryRequest> down_;
  LinkReader<MemoryResponse> up_;
  std::vector<Client> clients_;
  WaitingLinks waiting_;             ///< clients with waiting requests
  std::vector<Cycle> response_due_;  ///< [client] cycle in which its next response may enter the link, or kNever
  SectorCacheTags tags_;
  MshrTable mshrs_;
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
  Cycle ticked_ = kNever;  ///< the cycle of the last tick
  std::uint64_t dirty_at_start_ = 0;
  RequestStages* stages_ = nullptr;
  Cycle asked_ = 0;  ///< if observed: when the request under way came
  L1Counters counters_;
};

}  // namespace grtx::modules
