// SPDX-License-Identifier: Apache-2.0
// Interface between the RT scheduler and the stack unit, used if stacks may exceed the warp buffer.
#pragma once

#include <cstdint>
#include <systemc>

#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/rt_unit/part/rt_part.h"

namespace grtx::modules {

struct StackCounters;

/// The RT scheduler's view of the stack unit.
class stack_if : public virtual sc_core::sc_interface {
 public:
  /// A lane begins a round in warp slot `slot` with nothing spilled.
  virtual void begin_lane(LaneId id, std::uint16_t slot) = 0;
  /// The lane's stack now has `depth` entries. takes_top: its next event takes the top entry. Returns whether the lane
  /// must wait for a spill or fill; if so, stack_settled() is called later.
  virtual bool settle(LaneId id, std::uint32_t depth, bool takes_top) = 0;
};

/// Callback of the stack unit, implemented by the RT scheduler.
class stack_client_if : public virtual sc_core::sc_interface {
 public:
  /// The lane's spill or fill is complete.
  virtual void stack_settled(LaneId id) = 0;
};

/// Base class of stack units.
class StackModule : public RtMemoryPart, public stack_if {
 public:
  sc_core::sc_port<stack_client_if> client{"client"};
  LinkOut<MemoryRequest> request{"request"};
  LinkIn<MemoryResponse> response{"response"};

  /// Counters since the start of the launch.
  virtual StackCounters counters() const = 0;

 protected:
  using RtMemoryPart::RtMemoryPart;
};

}  // namespace grtx::modules
