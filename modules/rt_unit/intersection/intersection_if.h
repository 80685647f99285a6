// SPDX-License-Identifier: Apache-2.0
// Interfaces of intersection units: the node dispatch passes lanes to a unit, and the RT scheduler receives the
// results.
#pragma once

#include <systemc>

#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/rt_unit/part/rt_part.h"
#include "grtx/traces/node_layout.h"

namespace grtx::modules {

struct IntersectionCounters;

/// Input side of an intersection unit, called by the node dispatch.
class intersection_if : public virtual sc_core::sc_interface {
 public:
  /// Requests `tests` (>= 1) tests of lane `id`'s node. A lane has at most one request at a time; when warps
  /// walk together (rt.traversal), `id` is a walk_test(), and a lane may have several requests. May be called after
  /// the unit's tick() in the same cycle; the earliest start is the next cycle.
  virtual void enqueue(Cycle now, LaneId id, unsigned tests) = 0;
  /// Requests from here on are of another node.
  virtual void begin_node() {}
};

/// The node dispatch as the warp walk scheduler sees it.
class node_test_if : public virtual sc_core::sc_interface {
 public:
  /// Passes a lane at a node of this kind, which has been fetched, to the unit that tests it. children: of an internal
  /// node. The result comes with `test` as the lane's number.
  virtual void test(Cycle now, LaneId test, traces::NodeKind kind, unsigned children) = 0;
  /// Tests of nodes of this kind are of another node from here on.
  virtual void begin_node(traces::NodeKind kind) = 0;
};

/// Receives results.
class intersection_client_if : public virtual sc_core::sc_interface {
 public:
  /// The lane's intersection result is available: once per enqueue(), in a later cycle. Also called when a fetched node
  /// is a box leaf, which no unit tests.
  virtual void unit_result(Cycle now, LaneId id) = 0;
};

/// A ray-box, ray-triangle, ray-sphere or ray-transform unit. To model one of your own, derive from this, keep due_
/// up to date, and pass a factory to the RT unit (RtUnitParts).
class IntersectionModule : public RtPart, public intersection_if {
 public:
  sc_core::sc_port<intersection_client_if> client{"client"};

  /// First cycle in which tick() has something to do.
  Cycle due() const { return due_; }
  /// Called once per cycle from due() on: delivers the results of this cycle and starts waiting requests.
  virtual void tick(Cycle now) = 0;

  /// Counters since the start of the launch.
  virtual IntersectionCounters counters() const = 0;

 protected:
  using RtPart::RtPart;
  Cycle due_ = kNever;  ///< maintained by the derived unit
};

}  // namespace grtx::modules
