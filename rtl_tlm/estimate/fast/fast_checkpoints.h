// The checkpoint unit in fast mode: the sectors that entries take to write and to read.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "grtx/modules/rt_unit/checkpoint_unit.h"
#include "grtx/modules/rt_unit/decide/checkpoint_layout.h"
#include "grtx/rtl_tlm/estimate/fast/fast_l1.h"
#include "grtx/rtl_tlm/estimate/fast/slot_calendar.h"

namespace grtx::sim::fast {

class Checkpoints {
 public:
  Checkpoints(Shared& shared, unsigned sm, L1& l1);

  /// The lane begins round `round`, with these events, in resident slot `slot`. ray: the lane's.
  void begin(std::uint32_t lane, unsigned slot, std::uint32_t round, bool replay, std::span<const traces::Event> events,
             const traces::Ray& ray);
  /// The lane's entries go to its destination. last: its round is over. Returns when all has been handed over.
  Cycle write(Cycle now, std::uint32_t lane, unsigned entries, bool last);
  /// Whether the lane's next source entry is there already; else it is on the agenda.
  bool read(Cycle now, std::uint32_t lane);
  /// The L1 has answered.
  void answered(std::uint32_t lane, Cycle seen, bool write, bool last);
  void advance(Cycle now) { hand_over_.advance(now); }

  // The same without time.
  void warm_write(std::uint32_t lane, unsigned entries, bool last);
  void warm_read(std::uint32_t lane);

  const modules::CheckpointUnit::Counters& counters() const { return counters_; }

 private:
  /// A lane's buffers, or bins.
  struct Lane {
    modules::CheckpointLayout::Lane place;
    Cycle seen = 0;  ///< when the sectors asked for are there
  };
  void submit(Lane& lane, unsigned entries);
  modules::CheckpointLayout::Sectors next_written(Lane& lane);
  modules::CheckpointLayout::Sectors next_read(Lane& lane);
  void push(Cycle now, std::uint32_t lane, std::uint64_t sector, bool write, bool last);
  void warm(std::uint64_t sector, bool write) {
    l1_.warm(kCheckpoint, {sector * modules::kSectorBytes, modules::Region::checkpoint}, write);
  }

  Shared& shared_;
  unsigned sm_;
  L1& l1_;
  modules::CheckpointLayout layout_;
  std::vector<Lane> lanes_;
  SlotCalendar hand_over_;   ///< of entries
  Cycle blocked_until_ = 0;  ///< a lane waits to hand over entries
  modules::CheckpointUnit::Counters counters_;
};

}  // namespace grtx::sim::fast
