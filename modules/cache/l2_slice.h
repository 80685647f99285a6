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
#include "grtx/modules/cache/cache_state.h"
#include "grtx/modules/cache/decide/mshr_table.h"
#include "grtx/modules/cache/decide/sector_cache_tags.h"
#include "grtx/modules/cache/l2_slice_if.h"
#include "grtx/modules/cache/request_stages.h"
#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/messages/address_interleave.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/tlm/at_initiator.h"

namespace grtx::modules {

class L2Slice final : public L2SliceModule {
 public:
  using Config = L2SliceConfig;

  /// clock: core domain. Throws Error for an impossible configuration.
  L2Slice(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock);

  AtInitiator dram;
  ::tlm::tlm_initiator_socket<32>& memory_socket() override { return dram.socket; }

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
  void hold_requests() override { dram.hold(); }
  void on_refusal(const AtInitiator::Refused& refused) override { dram.on_refusal(refused); }
  void preload(std::uint64_t address) override;
  void save(StateWriter& state) const override;
  void load(StateReader& state) override;
  const Config& config() const { return config_; }
  /// From now on it is told of reads; nullptr: of none, the default.
  void observe(RequestStages* stages) { stages_ = stages; }

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
  template <bool kObserved>
  Cycle work(Cycle now);
  void restart(Caches caches) override;
  bool work_at(Cycle now) const;
  template <bool kObserved>
  void take_request(Cycle now);
  void take_completion(Cycle now);
  bool fill(Cycle now, std::uint32_t mshr);
  bool install(const MemoryRequest& access);
  void look_up(Cycle now);
  bool read(Cycle now, const MemoryRequest& access);
  bool write(const MemoryRequest& access);
  bool stall(L2Stall reason);
  void prefetch_host(Cycle now) const;
  // local: address of `access` in the slice.
  bool room_for_victim(std::uint64_t local, const MemoryRequest& access) const;
  SectorCacheTags::Slot allocate(std::uint64_t local, const MemoryRequest& access);
  void write_back(const SectorCacheTags::Victim& victim, Region region);
  void reply(const MemoryRequest& access);
  void send_dram(Cycle now);
  template <bool kObserved>
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
  RingQueue<Access> pipe_;
  RingQueue<MemoryResponse> replies_;
  RingQueue<DramRequest> dram_queue_;
  Cycle due_ = kNever;
  Cycle mshr_counted_ = 0;
  RequestStages* stages_ = nullptr;
  L2Counters counters_;
};

}  // namespace grtx::modules
