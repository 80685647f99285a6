// The shared half of the memory in the outline model: crossbar, L2 slices and DRAM channels as resources that requests
// reserve when they leave an SM. A request is for sectors of one line.
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "modules/address_interleave.h"
#include "modules/sector_cache_tags.h"
#include "rtl_tlm/fast/port_calendar.h"
#include "rtl_tlm/fast/slot_calendar.h"
#include "rtl_tlm/gpu_config.h"

namespace grtx::tlm {

/// The last N times of something: a queue of N places has room when the oldest of them has passed.
class PlaceRing {
 public:
  explicit PlaceRing(std::size_t places) : times_(std::max<std::size_t>(1, places)) {}
  Cycle room() const { return times_[next_]; }
  void take(Cycle until) {
    times_[next_] = until;
    next_ = next_ + 1 == times_.size() ? 0 : next_ + 1;
  }

 private:
  std::vector<Cycle> times_;
  std::size_t next_ = 0;
};

/// One DRAM channel, in memory clocks. Requests that find a row of theirs open, or about to be opened, join it, as an
/// FR-FCFS scheduler would serve them; others open theirs after those before them in the bank.
class OutlineChannel {
 public:
  explicit OutlineChannel(const modules::DramChannelConfig& config);
  /// Bursts of one row that arrive at `clock`. Returns when the last data is there.
  Cycle request(Cycle clock, std::uint64_t local, unsigned bursts, bool write);
  /// When the queue has room for one more.
  Cycle room() const { return queue_.room(); }
  void advance(Cycle clock) {
    bus_.advance(clock);
    activates_.advance(clock);
  }

 private:
  struct Row {
    std::uint64_t number = ~std::uint64_t{0};
    Cycle activated = 0, column = 0;
  };
  struct Bank {
    Row newest, before;
    Cycle last_column = 0;
    bool wrote = false;
  };
  modules::DramChannelConfig config_;
  std::vector<Bank> banks_;
  SlotCalendar bus_, activates_;
  Cycle writes_until_ = 0;  ///< until when writes find the bus turned around for them
  PlaceRing queue_;
};

class OutlineMemory {
 public:
  OutlineMemory(const GpuConfig& config, const modules::Dram::Config& dram);

  struct Trip {
    Cycle crossed = 0;  ///< the last sector left the SM's miss queue
    Cycle seen = 0;     ///< all of them are at the SM
  };
  /// sectors: mask within the line. sent: earliest cycle out of the SM.
  Trip access(unsigned sm, std::uint64_t line, std::uint8_t sectors, bool write, Cycle sent);
  void advance(Cycle now);
  void prefetch_host(std::uint64_t line) const {
    slices_[interleave_.slice(line)].tags.prefetch(interleave_.local(line));
  }

  std::uint64_t accesses = 0, dram_sectors = 0;

 private:
  struct Slice {
    Slice(const modules::L2Slice::Config& c, const modules::DramChannelConfig& channel, std::size_t capacity)
        : tags(c.geometry), looked_up(capacity), queue(c.dram_queue), mshrs(c.mshr_entries), dram(channel) {}
    modules::SectorCacheTags tags;
    PortCalendar input, lookup, reply;
    PlaceRing looked_up, queue, mshrs;
    Cycle blocked_until = 0;
    OutlineChannel dram;
  };
  Cycle clock_of(Cycle cycle) const { return static_cast<Cycle>(static_cast<double>(cycle) * clocks_a_cycle_) + 1; }
  Cycle cycle_of(Cycle clock) const { return static_cast<Cycle>(static_cast<double>(clock) / clocks_a_cycle_) + 1; }
  Cycle look_up(Slice& slice, std::uint64_t line, std::uint8_t sectors, bool write, Cycle now);
  Cycle from_dram(Slice& slice, Cycle now, std::uint64_t local, unsigned sectors, bool write);

  double clocks_a_cycle_;
  Cycle link_, latency_, pipe_;
  modules::AddressInterleave interleave_;
  modules::Dram::Config dram_;
  bool perfect_;
  unsigned sector_bytes_;
  std::vector<Cycle> inputs_;
  std::vector<Slice> slices_;
};

}  // namespace grtx::tlm
