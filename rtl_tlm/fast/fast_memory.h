// The shared half of the memory in fast mode: crossbar, L2 slices and DRAM channels. A request is followed through all
// of them when it is sent: ports are resources in which it reserves the first free cycle, tags are looked up once. Only
// the DRAM's commands are simulated, by the cycle model's scheduler, in the order of time and a little later: how long
// a read will wait is predicted, from the requests before it and from what earlier predictions missed.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "modules/dram.h"
#include "modules/dram_channel.h"
#include "modules/l2_slice.h"
#include "modules/memory_request.h"
#include "modules/ring_queue.h"
#include "modules/sector_cache_tags.h"
#include "rtl_tlm/fast/port_calendar.h"
#include "rtl_tlm/gpu_config.h"

namespace grtx::tlm {

class FastMemory {
 public:
  /// Of one request, in core cycles.
  struct Trip {
    Cycle crossed = 0;  ///< it left the SM's queue towards the crossbar
    Cycle seen = 0;     ///< its reply is visible at the SM
  };

  /// bytes: size of the memory.
  FastMemory(const GpuConfig& config, std::uint64_t bytes);

  /// A miss or write that may leave the L1 in cycle `sent`; those of an SM cross in the order of the calls.
  Trip access(const modules::MemoryRequest& request, Cycle sent);
  /// Asks the host for what an access will read.
  void prefetch_host(std::uint64_t address) const {
    slices_[interleave_.slice(address)].tags.prefetch(interleave_.local(address));
  }
  /// Nothing will be sent before cycle `now` any more.
  void advance(Cycle now);
  /// Nothing will be sent any more.
  void drain();
  bool idle() const;

  // Counts in the form of the cycle model's.
  const std::vector<modules::L2Counters>& slices() const { return l2_; }
  modules::DramCounters dram(Cycle end) const;
  std::vector<modules::DramChannelCounters> channels() const;
  std::uint64_t packets() const { return packets_; }  ///< through either network of the crossbar
  std::uint64_t dirty_sectors() const;

 private:
  static constexpr std::uint64_t kWriteBack = ~std::uint64_t{0};  ///< id of a request that nobody waits for
  static constexpr std::size_t kSamples = 64;                     ///< reads whose missed predictions are kept
  static constexpr std::int64_t kParts = 4096;                    ///< of a clock, in the measured pace

  /// A request on its way to the DRAM.
  struct Arrival {
    Cycle clock = 0;            ///< of the memory, earliest
    std::uint64_t address = 0;  ///< inside the channel
    std::uint64_t id = 0;       ///< of a read: clock and the requests it found, packed
  };
  struct Slice {
    Slice(const modules::L2Slice::Config& c, const modules::DramChannelConfig& channel, std::size_t capacity)
        : config(c), tags(c.geometry), looked_up(capacity), dram(channel) {}
    modules::L2Slice::Config config;
    modules::SectorCacheTags tags;
    PortCalendar input, lookup, reply;
    std::vector<Cycle> looked_up;  ///< of as many requests as fit between the crossbar and the tags
    std::size_t next = 0;          ///< in looked_up
    Cycle blocked_until = 0;       ///< the queue to the DRAM was full
    modules::DramChannel dram;
    std::vector<Arrival> arrivals;  ///< not at the DRAM yet, in the order of time
    void arrive(const Arrival& arrival);
    modules::RingQueue<Cycle> done;  ///< memory clocks of answers, later than the one to which all is known
    std::uint64_t outstanding = 0;   ///< in the DRAM
    Cycle arrival_free = 0;          ///< memory clock of the next request
    Cycle response_free = 0;         ///< memory clock of the next response
    // What a read's latency is predicted from: requests found times `interval` (of a memory clock, kParts parts), plus
    // the difference that an earlier read had to that (memory clocks).
    std::int64_t interval = 0;
    Cycle last_done = 0;
    std::array<std::int32_t, kSamples> errors{};
    std::size_t newest_sample = 0, next_sample = 0;
  };

  Cycle look_up(unsigned index, Cycle now, const modules::MemoryRequest& request);
  void write_back(unsigned index, Cycle now, const modules::SectorCacheTags::Victim& victim);
  Cycle ask_dram(Slice& slice, Cycle clock, std::uint64_t local, bool write);
  void run_dram(Slice& slice, Cycle clock);
  std::size_t waiting(const Slice& slice) const {
    return slice.arrivals.size() + slice.outstanding + slice.done.size();
  }
  // First edge of the other clock after that of a cycle.
  Cycle after_core(Cycle cycle) const { return scaled(cycle, core_in_memory_) + 1; }
  Cycle after_memory(Cycle clock) const { return scaled(clock, memory_in_core_) + 1; }
  /// whole + fraction / 2^64: scaling by it is a multiplication, where a division would take longer.
  struct Ratio {
    std::uint64_t whole, fraction;
  };
  static Ratio ratio(std::uint64_t a, std::uint64_t b);
  static Cycle scaled(Cycle cycle, const Ratio& r) {
    return cycle * r.whole + static_cast<Cycle>((static_cast<unsigned __int128>(cycle) * r.fraction) >> 64);
  }

  std::uint64_t core_fs_, memory_fs_;      ///< clock periods
  Ratio core_in_memory_, memory_in_core_;  ///< core_fs_ / memory_fs_ and its inverse
  Cycle link_;                             ///< from an L1 to the crossbar
  Cycle latency_;  ///< crossbar with the link before it: from leaving an L1 or a slice to being seen at the other end
  Cycle pipe_;     ///< of a slice: from its input to its tags
  modules::AddressInterleave interleave_;
  modules::Dram::Config dram_;
  unsigned sector_bytes_;
  std::vector<Cycle> inputs_;  ///< by SM: earliest crossing of its next request
  std::vector<Slice> slices_;
  std::vector<modules::L2Counters> l2_;
  std::vector<PortCalendar> ports_;  ///< by SM, for replies
  Cycle next_advance_ = 0;           ///< of the calendars
  std::uint64_t packets_ = 0;
  std::uint64_t responses_ = 0;
  std::uint64_t full_clocks_ = 0;
};

}  // namespace grtx::tlm
