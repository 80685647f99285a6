// Between the RT scheduler and the stack unit, where stacks may be deeper than the warp buffer holds.
#pragma once

#include <cstdint>
#include <systemc>

#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/rt_unit/rt_part.h"

namespace grtx::modules {

struct StackCounters;

/// The RT scheduler's view of the stack unit.
class stack_if : public virtual sc_core::sc_interface {
 public:
  /// A lane begins a round in resident slot `slot` with nothing spilled.
  virtual void begin_lane(LaneId id, std::uint16_t slot) = 0;
  /// The lane's stack has `depth` entries now; takes_top: its next event takes the top one. Returns whether the lane
  /// must wait for a spill or a fill; then stack_settled() names it later.
  virtual bool settle(LaneId id, std::uint32_t depth, bool takes_top) = 0;
  /// Functional entry (RtMemoryPart::has_touch()): the same without time, in cycle `at`.
  virtual void touch_settle(LaneId /*id*/, std::uint32_t /*depth*/, bool /*takes_top*/, Cycle /*at*/) {}
};

/// Who goes on with the lanes.
class stack_client_if : public virtual sc_core::sc_interface {
 public:
  /// The lane's stack entries have been spilled, or filled.
  virtual void stack_settled(LaneId id) = 0;
};

/// A stack unit.
class StackModule : public RtMemoryPart, public stack_if {
 public:
  sc_core::sc_port<stack_client_if> client{"client"};
  LinkOut<MemoryRequest> request{"request"};
  LinkIn<MemoryResponse> response{"response"};

  /// What it has counted since the launch began.
  virtual StackCounters counters() const = 0;

 protected:
  using RtMemoryPart::RtMemoryPart;
};

}  // namespace grtx::modules
