// The L1 of an SM in fast mode: the tags of the cycle model. A request learns at once when the L1 takes it and when its
// answer is there; the sectors that are under way go into the tags when they arrive.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "modules/address_index.h"
#include "modules/l1_cache.h"
#include "modules/memory_request.h"
#include "modules/sector_cache_tags.h"
#include "rtl_tlm/fast/due_wheel.h"
#include "rtl_tlm/fast/fast_memory.h"
#include "rtl_tlm/fast/slot_calendar.h"

namespace grtx::tlm {

class FastL1 {
 public:
  /// Of one request.
  struct Access {
    Cycle taken = 0;  ///< the L1 accepted it; the next of its client comes later
    Cycle seen = 0;   ///< the response is visible to the client
    bool hit = false;
  };

  /// link_capacity: of the link to the crossbar.
  FastL1(const modules::L1Cache::Config& config, unsigned sm, std::size_t link_capacity, FastMemory& memory);

  /// A request that the L1 looks at in cycle `now` or, when a full miss queue or no free MSHR holds it back, later.
  Access access(Cycle now, const modules::MemoryRequest& request) { return serve(take_bank(now, request), request); }
  /// As access(), of a client that asks after one that asked ahead of time: half of the time it goes first, as turns in
  /// the priority have it, and the other one's next request comes a cycle later.
  Access access_between(Cycle now, const modules::MemoryRequest& request) {
    Cycle bank = take_bank(now, request);
    if (bank != now && (between_ = !between_)) {
      ++overtaken_;
      bank = now;
    }
    return serve(bank, request);
  }
  /// How often access_between() went first since the last call.
  Cycle take_overtaken() { return std::exchange(overtaken_, 0); }
  Cycle latency() const { return config_.latency; }
  /// Nothing will be asked before cycle `now` any more.
  void advance(Cycle now) {
    for (SlotCalendar& bank : banks_) bank.advance(now);
  }
  /// Asks the host for what an access will read.
  void prefetch_host(std::uint64_t address) const {
    tags_.prefetch(address);
    memory_.prefetch_host(address);
  }
  /// Takes in what is still under way at the end.
  void drain();
  modules::L1Counters counters() const;

 private:
  /// A sector under way, in one of the MSHRs.
  struct Miss {
    std::uint64_t address = 0;
    Cycle arrives = 0;
    bool demanded = false;
  };

  Cycle take_bank(Cycle now, const modules::MemoryRequest& request) {
    const Cycle bank = banks_[request.address / modules::kSectorBytes % banks_.size()].reserve(now);
    counters_.stalls[static_cast<std::size_t>(modules::L1Stall::bank_conflict)] += bank - now;
    return bank;
  }
  Access serve(Cycle now, const modules::MemoryRequest& request) {
    return request.write ? write(now, request) : read(now, request);
  }
  Access read(Cycle now, const modules::MemoryRequest& request);
  Access write(Cycle now, const modules::MemoryRequest& request);
  /// Puts the sectors that have arrived by cycle `now` into the tags.
  void fill(Cycle now) {
    while (arrivals_.next() <= now) fill_next();
  }
  void fill_next();
  void store(DueWheel::Number miss);
  /// The miss queue and the link behind it have room.
  Cycle room(Cycle now);
  void reference(modules::SectorCacheTags::Slot slot, std::uint8_t sector);
  FastMemory::Trip send(Cycle now, modules::MemoryRequest request);

  modules::L1Cache::Config config_;
  std::uint8_t sm_;
  FastMemory& memory_;
  modules::SectorCacheTags tags_;
  std::vector<SlotCalendar> banks_;  ///< one access a cycle each
  bool between_ = false;
  Cycle overtaken_ = 0;
  std::vector<Miss> misses_;
  std::vector<DueWheel::Number> free_;  ///< of misses_
  DueWheel arrivals_;                   ///< of misses_
  modules::AddressIndex pending_;       ///< misses_ by sector
  std::vector<Cycle> crossed_;          ///< of as many requests as miss queue and link hold
  std::size_t next_crossed_ = 0;
  modules::L1Counters counters_;
};

}  // namespace grtx::tlm
