// SPDX-License-Identifier: Apache-2.0
// Base class of RT schedulers. The scheduler alone decides which warp proceeds and what an event does to a lane; all
// other parts report to it.
#pragma once

#include <systemc>

#include "grtx/modules/rt_unit/any_hit_if.h"
#include "grtx/modules/rt_unit/checkpoint_if.h"
#include "grtx/modules/rt_unit/intersection_if.h"
#include "grtx/modules/rt_unit/node_fetch_if.h"
#include "grtx/modules/rt_unit/prefetch_if.h"
#include "grtx/modules/rt_unit/stack_if.h"
#include "grtx/modules/rt_unit/warp_buffer_if.h"

namespace grtx::modules {

struct RtSchedulerCounters;

class RtSchedulerModule : public RtPart,
                          public warp_admission_if,
                          public intersection_client_if,
                          public any_hit_client_if,
                          public checkpoint_client_if,
                          public stack_client_if {
 public:
  /// Port to a part that only some configurations have.
  template <typename T>
  using Optional = sc_core::sc_port<T, 1, sc_core::SC_ZERO_OR_MORE_BOUND>;

  sc_core::sc_port<warp_buffer_if> warp_buffer{"warp_buffer"};
  sc_core::sc_port<node_fetch_if> node_fetch{"node_fetch"};
  sc_core::sc_port<any_hit_if> any_hit{"any_hit"};
  Optional<checkpoint_if> checkpoint{"checkpoint"};
  Optional<prefetch_if> prefetch{"prefetch"};
  Optional<stack_if> stack{"stack"};

  /// Selects a warp, if any is ready, and handles the next event of all its ready lanes.
  virtual void schedule(Cycle now) = 0;
  /// Counts `cycles` cycles in which nothing happened, under the stall reason of the current state.
  virtual void count_idle(Cycle cycles) = 0;
  /// Number of cycles so far in which a warp was scheduled.
  virtual std::uint64_t selections() const = 0;

  /// Counters since the start of the launch.
  virtual RtSchedulerCounters counters() const = 0;

 protected:
  using RtPart::RtPart;
};

/// Base class of schedulers whose warps walk together (rt.traversal = warp). They receive fetched nodes themselves,
/// since one node serves many lanes: a visit's lane number (node_fetch_if) is that of a node slot.
class WarpWalkModule : public RtSchedulerModule, public fetched_node_if {
 public:
  sc_core::sc_port<node_test_if> node_test{"node_test"};

 protected:
  using RtSchedulerModule::RtSchedulerModule;
};

}  // namespace grtx::modules
