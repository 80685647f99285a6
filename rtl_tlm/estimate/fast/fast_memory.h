// The shared half of the memory in fast mode: crossbar, L2 slices and DRAM channels as resources that requests reserve
// when they leave an SM. A request is for sectors of one line, which cross one after the other.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/modules/cache/decide/sector_cache_tags.h"
#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/dram/dram.h"
#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/messages/address_interleave.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/rtl_tlm/estimate/fast/arrivals.h"
#include "grtx/rtl_tlm/estimate/fast/fast_dram.h"
#include "grtx/rtl_tlm/estimate/fast/place_ring.h"
#include "grtx/rtl_tlm/estimate/fast/port_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/span_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/turn_calendar.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

class FastMemory {
 public:
  /// bytes: size of the memory.
  FastMemory(const GpuConfig& config, std::uint64_t bytes);

  /// When one request passes what it passes, in core cycles.
  struct Trip {
    Cycle crossed = 0;  ///< the SM sees that the last sector has left the link to the crossbar
    Cycle seen = 0;     ///< all of them are at the SM
  };
  struct Request {
    unsigned sm = 0;
    std::uint64_t line = 0;    ///< address
    std::uint8_t sectors = 0;  ///< mask within the line, not empty
    modules::Region region{};
    bool write = false;
  };
  /// A miss or write that may leave the L1 in cycle `sent`; those of an SM cross in the order of the calls.
  Trip access(const Request& request, Cycle sent);
  /// The same for the tags, at once and uncounted.
  void warm(const Request& request);
  /// To be called when all has been sent, before counts are read.
  void finish();
  /// Nothing will be sent before cycle `now` any more.
  void advance(Cycle now);

  /// Before the first request: lines and open rows are those that `before` has left, which loses them.
  void keep(FastMemory& before);
  /// What keep() takes over.
  void save(StateWriter& state) const;
  void load(StateReader& state);

  // Counts in the form of the cycle model's.
  const std::vector<modules::L2Counters>& slices() const { return l2_; }
  modules::DramCounters dram(const std::vector<modules::DramChannelCounters>& channels, Cycle end) const;
  std::vector<modules::DramChannelCounters> channels() const;
  /// The same, without the bursts that come after core cycle `end`.
  std::vector<modules::DramChannelCounters> channels_by(Cycle end) const;
  std::uint64_t dirty_sectors() const;

 private:
  struct Write {  ///< sectors of a line that has left a slice
    Cycle clock = 0;
    std::uint64_t address = 0;  ///< inside the channel
    unsigned sectors = 0;
  };
  struct Slice {
    Slice(const modules::L2Slice::Config& c, std::size_t capacity, unsigned response)
        : tags(c.geometry),
          written_by(tags.slots()),
          arrivals(tags.slots(), c.geometry.sectors()),
          looked_up(capacity),
          queue(c.dram_queue),
          mshrs(c.mshr_entries),
          responses(response) {}
    modules::SectorCacheTags tags;
    std::vector<modules::Region> written_by;  ///< by line of the tags: of its dirty sectors
    Arrivals arrivals;                        ///< by line of the tags
    TurnCalendar input;
    PortCalendar lookup, reply;
    PlaceRing looked_up;               ///< of as many requests as fit between the crossbar and the tags
    PlaceCalendar queue;               ///< to the DRAM, in memory clocks
    PlaceCalendar mshrs;               ///< in core cycles
    Cycle blocked_until = 0;           ///< the queue to the DRAM or the MSHRs were full
    SpanCalendar responses;            ///< of the DRAM, to reads and writes, in memory clocks
    modules::RingQueue<Write> writes;  ///< which the DRAM does not know of yet
  };
  // First edge of the other clock after that of a cycle.
  Cycle clock_of(Cycle cycle) const { return static_cast<Cycle>(static_cast<double>(cycle) * clocks_a_cycle_) + 1; }
  Cycle cycle_of(Cycle clock) const { return static_cast<Cycle>(static_cast<double>(clock) / clocks_a_cycle_) + 1; }
  /// The line's place in the tags of a slice, which it gets if it has none.
  modules::SectorCacheTags::Slot find_or_insert(Slice& slice, std::uint64_t local,
                                                modules::SectorCacheTags::Victim& victim);
  Cycle look_up(unsigned index, const Request& request, Cycle now);
  /// One sector: when it is in the slice.
  Cycle read_dram(unsigned index, Cycle now, std::uint64_t local);
  /// The data of the last of so many sectors is there: when the last of their responses begins.
  Cycle respond(Slice& slice, Cycle done, unsigned sectors);
  /// A line has left the slice.
  void write_back(unsigned index, Cycle now, const modules::SectorCacheTags::Victim& victim, modules::Region region);
  /// Gives a channel what has left its slices up to memory clock `clock`.
  void write_dram(unsigned channel, Cycle clock);

  std::uint64_t core_fs_, memory_fs_;  ///< clock periods
  double clocks_a_cycle_;
  Cycle gap_;      ///< between two requests of an SM: a link with one place carries something in every other cycle
  Cycle link_;     ///< from an L1 to the crossbar
  Cycle latency_;  ///< crossbar with the link before it: from leaving an L1 or a slice to being seen at the other end
  Cycle pipe_;     ///< of a slice: from its input to its tags
  modules::AddressInterleave interleave_;
  modules::Dram::Config dram_;
  bool perfect_;  ///< L2
  unsigned sector_bytes_;
  std::vector<Cycle> inputs_;          ///< by SM: earliest crossing of its next request
  std::vector<PortCalendar> replies_;  ///< by SM: takes one a cycle
  std::vector<Slice> slices_;
  std::vector<FastDramChannel> dram_channels_;
  std::vector<modules::L2Counters> l2_;
};

}  // namespace grtx::sim
