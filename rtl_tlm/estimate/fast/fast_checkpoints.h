// The checkpoint unit in fast mode: the sectors that entries take to write and to read.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/rt_unit/checkpoint_unit.h"
#include "grtx/modules/rt_unit/decide/checkpoint_layout.h"
#include "grtx/rtl_tlm/estimate/fast/fast_l1.h"
#include "grtx/rtl_tlm/estimate/fast/slot_calendar.h"

namespace grtx::sim::fast {

class Checkpoints {
 public:
  Checkpoints(Shared& shared, unsigned sm, L1& l1);

  /// The lane begins round `round`, with these events, in resident slot `slot`.
  void begin(Cycle now, std::uint32_t lane, unsigned slot, std::uint32_t round, bool replay,
             std::span<const traces::Event> events);
  /// The lane's entries go to its destination buffer. forwarded: it is the one that it read last. last: its round is
  /// over. Returns when all has been handed over.
  Cycle write(Cycle now, std::uint32_t lane, unsigned entries, bool forwarded, bool last);
  /// Whether the lane's next source entry is there already; else it, or the run entry before it, is on the agenda.
  bool read(Cycle now, std::uint32_t lane);
  /// What the lane waited for has come. Returns whether that was the entry; else it is on the agenda.
  bool entry_read(Cycle now, std::uint32_t lane);
  /// The L1 has answered.
  void answered(std::uint32_t lane, Cycle seen, bool write, bool last);
  /// The same, of a sector that was read ahead.
  void answered_ahead(std::uint32_t lane, Cycle seen, std::uint64_t line, std::uint8_t sectors);
  /// f(first, count, whether it takes time) for the lane's source entries that have come by now ahead of being read.
  template <typename F>
  void for_each_arrived(Cycle now, std::uint32_t lane, F&& f) {
    modules::RingQueue<Arrival>& arrivals = lanes_[lane].arrivals;
    while (!arrivals.empty() && arrivals.front().seen <= now) {
      const Arrival arrival = arrivals.front();
      arrivals.pop();
      const modules::CheckpointLayout::Entries entries = layout_.arrived(lanes_[lane].place, arrival.sector);
      if (entries.count > 0) f(entries.first, entries.count, arrival.timed);
    }
    lanes_[lane].arriving = !arrivals.empty();
    if (!arrivals.empty()) shared_.agenda.add(arrivals.front().seen, {What::source, sm_, lane});
  }
  bool names_nodes() const { return layout_.names_nodes(); }
  void advance(Cycle now) {
    hand_over_.advance(now);
    store_write_.advance(now);
    store_read_.advance(now);
  }

  // The same without time.
  void warm_write(std::uint32_t lane, unsigned entries, bool forwarded, bool last);
  void warm_read(Cycle now, std::uint32_t lane);

  modules::CheckpointUnit::Counters counters() const { return counters_.with_runs_of(layout_); }

 private:
  /// A sector.
  struct Arrival {
    Cycle seen = 0;
    std::uint64_t sector = 0;
    bool timed = true;
  };
  /// A lane's buffers.
  struct Lane {
    modules::CheckpointLayout::Lane place;
    Cycle seen = 0;    ///< when the sectors asked for are there
    bool run = false;  ///< they are of a run entry
    modules::CheckpointLayout::Sectors asked;
    modules::RingQueue<Arrival> arrivals{2};  ///< of its source buffer, whose entries are to be looked at
    bool arriving = false;                    ///< the first of them is on the agenda
  };
  unsigned submit(Lane& lane, unsigned entries, bool forwarded, bool last);
  modules::CheckpointLayout::Sectors next_written(Lane& lane);
  modules::CheckpointLayout::Sectors next_read(Lane& lane);
  void push(Cycle now, std::uint32_t lane, std::uint64_t sector, bool write, bool last);
  void read_ahead(Cycle now, std::uint32_t lane, bool timed);
  void arrives(std::uint32_t lane, const Arrival& arrival);
  void warm(std::uint64_t sector, bool write) {
    l1_.warm(kCheckpoint, {sector * modules::kSectorBytes, modules::Region::checkpoint}, write);
  }

  Shared& shared_;
  unsigned sm_;
  L1& l1_;
  modules::CheckpointLayout layout_;
  std::vector<Lane> lanes_;
  SlotCalendar hand_over_;                 ///< of entries
  SlotCalendar store_write_, store_read_;  ///< ports of the private store
  Cycle blocked_until_ = 0;                ///< a lane waits to hand over entries
  modules::CheckpointUnit::Counters counters_;
};

}  // namespace grtx::sim::fast
