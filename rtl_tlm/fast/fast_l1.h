// The L1 of an SM in fast mode: the tags of the cycle model. A request learns at once when the L1 takes it and when its
// answer is there; the sectors that are under way go into the tags when they arrive.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "modules/address_index.h"
#include "modules/l1_cache.h"
#include "modules/memory_request.h"
#include "modules/sector_cache_tags.h"
#include "rtl_tlm/fast/due_wheel.h"
#include "rtl_tlm/fast/fast_memory.h"
#include "rtl_tlm/fast/port_calendar.h"

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

  /// Numbers of the clients, in the order of the cycle model's: its turns in the priority follow them.
  enum Client : unsigned { kNode, kSimt, kCheckpoint, kPrefetch, kClients };

  /// A request that the L1 looks at in cycle `now`. Without a free MSHR or a place in the miss queue it is refused:
  /// then `taken` is kNever and `seen` the cycle in which to ask again.
  Access access(Cycle now, const modules::MemoryRequest& request, Client client) {
    return request.write ? write(now, request, client) : read(now, request, client);
  }
  /// How often a client went before a node request that had been asked ahead of time, since the last call: as often is
  /// the next node request a cycle later.
  Cycle take_overtaken() { return std::exchange(overtaken_, 0); }
  Cycle latency() const { return config_.latency; }
  /// Nothing will be asked before cycle `now` any more.
  void advance(Cycle now) {
    for (PortCalendar& bank : banks_) bank.advance(now);
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

  Access read(Cycle now, const modules::MemoryRequest& request, Client client);
  Access write(Cycle now, const modules::MemoryRequest& request, Client client);
  /// When the bank takes the request. Node requests ask ahead of time, so half of the time the others go first.
  Cycle take_bank(Cycle now, const modules::MemoryRequest& request, Client client);
  /// Whether it is this client's turn, now that there is room for one more miss.
  bool turn_of(Cycle now, Client client);
  Access refuse(Cycle now, Cycle until, Client client, modules::L1Stall reason);
  /// Puts the sectors that have arrived by cycle `now` into the tags.
  void fill(Cycle now) {
    while (arrivals_.next() <= now) fill_next();
  }
  void fill_next();
  void store(DueWheel::Number miss);
  /// When the miss queue and the link behind it have room.
  Cycle room() const {
    const Cycle crossed = crossed_[next_crossed_];
    return crossed > config_.tag_latency ? crossed - config_.tag_latency : 0;
  }
  void reference(modules::SectorCacheTags::Slot slot, std::uint8_t sector);
  FastMemory::Trip send(Cycle now, modules::MemoryRequest request);

  modules::L1Cache::Config config_;
  std::uint8_t sm_;
  FastMemory& memory_;
  modules::SectorCacheTags tags_;
  std::vector<PortCalendar> banks_;
  unsigned bank_mask_;    ///< banks - 1 for a power of two of banks, else 0
  bool between_ = false;  ///< the next bank conflict is the node request's
  Cycle overtaken_ = 0;
  std::array<Cycle, kClients> again_{};  ///< when a client asks again that was refused; 0: none was
  unsigned first_ = 0;                   ///< in the priority
  std::vector<Miss> misses_;
  std::vector<DueWheel::Number> free_;  ///< of misses_
  DueWheel arrivals_;                   ///< of misses_
  modules::AddressIndex pending_;       ///< misses_ by sector
  std::vector<Cycle> crossed_;          ///< of as many requests as miss queue and link hold
  std::size_t next_crossed_ = 0;
  modules::L1Counters counters_;
};

}  // namespace grtx::tlm
