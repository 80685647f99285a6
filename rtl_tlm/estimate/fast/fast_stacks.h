// The stack unit in fast mode: the sectors of stack entries that the warp buffer has no place for.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/modules/rt_unit/decide/stack_spill.h"
#include "grtx/modules/rt_unit/stack_unit.h"
#include "grtx/rtl_tlm/estimate/fast/fast_l1.h"
#include "grtx/rtl_tlm/estimate/fast/slot_calendar.h"

namespace grtx::sim::fast {

class Stacks {
 public:
  Stacks(Shared& shared, unsigned sm, L1& l1);

  /// The lane begins a round in resident slot `slot`.
  void begin(std::uint32_t lane, unsigned slot) {
    lanes_[lane] = {shared_.map.ray_slot(sm_, slot, lane % modules::kMaxLanes), {}};
  }
  /// The lane's stack has `depth` entries now; takes_top: its next event takes the top one. Returns when the lane goes
  /// on; kNever: when the L1 has answered.
  Cycle settle(Cycle now, std::uint32_t lane, std::uint32_t depth, bool takes_top);
  /// The same without time.
  void warm(std::uint32_t lane, std::uint32_t depth, bool takes_top);
  /// Entries of the lane that lie in memory, or are on their way there.
  std::uint32_t in_memory(std::uint32_t lane) const { return lanes_[lane].stack.in_memory; }
  /// The L1 has answered.
  void answered(std::uint32_t lane, Cycle seen, bool write);

  void advance(Cycle now) { port_.advance(now); }
  const modules::StackUnit::Counters& counters() const { return counters_; }

 private:
  struct Lane {
    std::uint64_t ray = 0;  ///< ray slot
    modules::StackSpill::Lane stack;
  };
  modules::StackSpill::Move move(Lane& lane, std::uint32_t depth, bool takes_top);

  Shared& shared_;
  unsigned sm_;
  L1& l1_;
  modules::StackSpill spill_;
  std::vector<Lane> lanes_;
  SlotCalendar port_;  ///< a sector a cycle is sent
  modules::StackUnit::Counters counters_;
};

}  // namespace grtx::sim::fast
