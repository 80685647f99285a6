// An RT scheduler: it alone decides which warp goes on and what an event does to a lane; every other part reports to
// it.
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
  /// A port of a part that not every configuration has.
  template <typename T>
  using Optional = sc_core::sc_port<T, 1, sc_core::SC_ZERO_OR_MORE_BOUND>;

  sc_core::sc_port<warp_buffer_if> warp_buffer{"warp_buffer"};
  sc_core::sc_port<node_fetch_if> node_fetch{"node_fetch"};
  sc_core::sc_port<any_hit_if> any_hit{"any_hit"};
  Optional<checkpoint_if> checkpoint{"checkpoint"};
  Optional<prefetch_if> prefetch{"prefetch"};
  Optional<stack_if> stack{"stack"};
  TouchPort<shader_touch_if> touch_shader{"touch_shader"};  ///< the SIMT core, for events without time

  /// Handles the next event of all ready lanes of the selected warp, if any can be selected.
  virtual void schedule(Cycle now) = 0;
  /// Has functional entries beside its timed ones, which sampled runs need. Then:
  virtual bool has_touch() const { return false; }
  /// Events without time that are due meet the caches.
  virtual void touch_until(Cycle /*now*/) {}
  /// `cycles` passed in which nothing happened: they have the reason of the present state.
  virtual void count_idle(Cycle cycles) = 0;
  /// Cycles in which a warp was scheduled, so far.
  virtual std::uint64_t selections() const = 0;

  /// What it has counted since the launch began.
  virtual RtSchedulerCounters counters() const = 0;

 protected:
  using RtPart::RtPart;
};

}  // namespace grtx::modules
