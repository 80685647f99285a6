// SPDX-License-Identifier: Apache-2.0
// Base class of RT schedulers. The scheduler alone decides which warp proceeds and what an event does to a lane; all
// other parts report to it.
#pragma once

#include <systemc>

#include "grtx/modules/rt_unit/any_hit_collector/any_hit_if.h"
#include "grtx/modules/rt_unit/checkpoint/checkpoint_if.h"
#include "grtx/modules/rt_unit/intersection/intersection_if.h"
#include "grtx/modules/rt_unit/memory_scheduler/node_fetch_if.h"
#include "grtx/modules/rt_unit/prefetcher/prefetch_if.h"
#include "grtx/modules/rt_unit/stack/stack_if.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_buffer_if.h"

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
  Optional<node_test_if> node_test{"node_test"};  ///< bound if fetched nodes come to the scheduler

  /// Selects a warp, if any is ready, and handles the next event of all its ready lanes.
  virtual void schedule(Cycle now) = 0;
  /// Whether there is work of the scheduler's own in this cycle: prepare() is then called before schedule().
  bool working() const { return working_; }
  virtual void prepare(Cycle /*now*/) {}
  /// Counts `cycles` cycles in which nothing happened, under the stall reason of the current state.
  virtual void count_idle(Cycle cycles) = 0;
  /// Number of cycles so far in which a warp was scheduled.
  virtual std::uint64_t selections() const = 0;
  /// With rt.traversal = warp, where one node is for many lanes, fetched nodes come to the scheduler, which passes
  /// lanes to their tests (node_test); a visit's lane number (node_fetch_if) is then that of a node slot. Null: they go
  /// to the node dispatch.
  virtual fetched_node_if* fetched_nodes() { return nullptr; }

  /// Counters since the start of the launch.
  virtual RtSchedulerCounters counters() const = 0;

 protected:
  using RtPart::RtPart;
  bool working_ = false;
};

}  // namespace grtx::modules
