// Between the RT scheduler, whose lanes may find their next node tested already, and the lane cooperation, which gives
// idle lanes of a warp nodes of busy ones.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <systemc>

#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/rt_unit/decide/node_visit.h"
#include "grtx/modules/rt_unit/rt_part.h"
#include "grtx/modules/rt_unit/stack_if.h"
#include "grtx/modules/rt_unit/warp_buffer_if.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

/// An idle lane fetches and tests a node that lies on the stack of a busy one.
struct Help {
  LaneId helper = 0;
  LaneId busy = 0;
  NodeVisit node;
};

/// What helpers have done of a lane's present visit.
enum class HelpState : std::uint8_t { none, under_way, tested };

class cooperation_if : public virtual sc_core::sc_interface {
 public:
  /// A lane begins a round of a ray of `group` with these events.
  virtual void begin_lane(LaneId id, const traces::RayGroup& group, std::span<const traces::Event> events) = 0;
  /// The lane comes to visit its node. tested: it has the result now. under_way: tested() will name it.
  virtual HelpState claim(LaneId id) = 0;
  /// The lane's present entry is culled: what helpers have done or are doing of it was for nothing.
  virtual void drop(LaneId id) = 0;
  /// The next idle lane of the warp in `entry` begins to help, if one can; call until there is none.
  virtual std::optional<Help> next(unsigned entry) = 0;
  /// Whether the lane helps: its fetch or its test is under way.
  virtual bool helps(LaneId id) const = 0;
  /// The test of a helping lane has its result, and the lane is idle again. Returns the lane that has waited for it.
  virtual std::optional<LaneId> tested(LaneId helper) = 0;
};

/// A lane cooperation.
class CooperationModule : public RtPart, public cooperation_if {
 public:
  sc_core::sc_port<warp_buffer_if> warp_buffer{"warp_buffer"};
  sc_core::sc_port<stack_if, 1, sc_core::SC_ZERO_OR_MORE_BOUND> stack{"stack"};

 protected:
  using RtPart::RtPart;
};

}  // namespace grtx::modules
