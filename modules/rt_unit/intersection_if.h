// Between the node dispatch, which hands lanes to an intersection unit, the unit, and the RT scheduler, which takes the
// results.
#pragma once

#include <systemc>

#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/rt_unit/rt_part.h"

namespace grtx::modules {

struct IntersectionCounters;

/// An intersection unit as seen by who feeds it.
class intersection_if : public virtual sc_core::sc_interface {
 public:
  /// Lane `id` asks for `tests` (>= 1) tests of its node. At most one request a lane at a time. May be called in the
  /// cycle in which the unit has ticked; the earliest start is the next cycle.
  virtual void enqueue(Cycle now, LaneId id, unsigned tests) = 0;
};

/// Who takes results.
class intersection_client_if : public virtual sc_core::sc_interface {
 public:
  /// The lane's intersection result is there: once for each enqueue(), in a later cycle. Or its node is a box, and has
  /// come.
  virtual void unit_result(Cycle now, LaneId id) = 0;
};

/// A ray-box, ray-triangle, ray-sphere or ray-transform unit. To model one of your own, derive from this, keep due_
/// true, and hand a factory to the RT unit (RtUnitParts).
class IntersectionModule : public RtPart, public intersection_if {
 public:
  sc_core::sc_port<intersection_client_if> client{"client"};

  /// First cycle in which tick() has something to do.
  Cycle due() const { return due_; }
  /// From due() on, once a cycle: hands out the results of this cycle and starts what waits.
  virtual void tick(Cycle now) = 0;

  /// What it has counted since the launch began.
  virtual IntersectionCounters counters() const = 0;

 protected:
  using RtPart::RtPart;
  Cycle due_ = kNever;  ///< kept by the derived unit
};

}  // namespace grtx::modules
