// The L1 of an SM in fast mode: tags, MSHRs and refusals of the cycle model; hits and misses take their latencies at
// once instead of moving through queues.
#pragma once

#include <algorithm>
#include <cstdint>

#include "modules/l1_cache.h"
#include "modules/memory_request.h"
#include "modules/mshr_table.h"
#include "modules/sector_cache_tags.h"
#include "rtl_tlm/fast/fast_memory.h"

namespace grtx::tlm {

class FastL1 {
 public:
  /// What became of a request.
  enum class Outcome : std::uint8_t {
    hit,       ///< the data is seen after latency() cycles
    pending,   ///< a fill or acknowledgement will name the requester
    conflict,  ///< the bank is taken in this cycle
    refused    ///< until retry_at()
  };

  /// link_capacity: of the link to the crossbar.
  FastL1(const modules::L1Cache::Config& config, unsigned sm, std::size_t link_capacity, FastMemory& memory);

  Cycle latency() const { return config_.latency; }
  /// Requests of one cycle share the banks. Cycles must not go back.
  Outcome access(Cycle now, modules::MemoryRequest request);
  /// A sector arrives: f(waiter, address) for each request that waits for it.
  template <typename F>
  void fill(Cycle now, const modules::MemoryResponse& reply, F&& f) {
    store(now, reply);
    for (const modules::MshrWaiter& waiter : mshrs_.waiters(reply.tag)) {
      ++counters_.responses;
      f(waiter, reply.address);
    }
    mshrs_.release(reply.tag);
  }
  /// A write is acknowledged.
  void acknowledge() {
    --writes_pending_;
    ++counters_.responses;
  }
  /// So many requests that were sent before cycle `now` have not crossed the crossbar yet.
  void crossing(std::size_t backlog, Cycle now) { send_free_ = std::max(send_free_, now + backlog); }
  /// When the last refusal may be over; kNever: not before the next fill.
  Cycle retry_at() const { return retry_at_; }
  bool idle() const { return mshrs_.used() == 0 && writes_pending_ == 0; }
  modules::L1Counters counters() const;

 private:
  Outcome read(Cycle now, const modules::MemoryRequest& request);
  Outcome write(Cycle now, const modules::MemoryRequest& request);
  Outcome refuse(modules::L1Stall reason, Cycle retry_at);
  /// As many wait for the crossbar as the miss queue and the link hold.
  bool miss_queue_full(Cycle now) const { return send_free_ >= now + config_.tag_latency + waiting_; }
  void store(Cycle now, const modules::MemoryResponse& reply);
  void send(Cycle now, const modules::MemoryRequest& request);
  void reference(modules::SectorCacheTags::Slot slot, std::uint8_t sector);
  void count_mshr_cycles(Cycle now);

  modules::L1Cache::Config config_;
  std::uint8_t sm_;
  Cycle waiting_;  ///< requests that miss queue and link hold
  FastMemory& memory_;
  modules::SectorCacheTags tags_;
  modules::MshrTable mshrs_;
  Cycle banks_cycle_ = modules::kNever;
  std::uint64_t banks_taken_ = 0;  ///< in banks_cycle_
  Cycle send_free_ = 0;            ///< towards the crossbar
  Cycle retry_at_ = 0;
  std::uint64_t writes_pending_ = 0;
  Cycle mshr_counted_ = 0;
  modules::L1Counters counters_;
};

}  // namespace grtx::tlm
