// SPDX-License-Identifier: Apache-2.0
// Interface between the RT scheduler, which learns of hits, and the part that handles them: the any-hit collector,
// which invokes the shader, or the any-hit unit.
#pragma once

#include <systemc>

#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/rt_unit/part/rt_part.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_buffer_if.h"

namespace grtx::modules {

struct AnyHitCounters;

/// The RT scheduler's view of the collector, or of the any-hit unit in its place.
class any_hit_if : public virtual sc_core::sc_interface {
 public:
  /// A lane begins a round with `preloaded` entries in its k-buffer.
  virtual void begin_lane(LaneId /*id*/, unsigned /*preloaded*/) {}
  /// The lane (in state in_unit) has a hit for the any-hit shader.
  virtual void arrive(Cycle now, LaneId id) = 0;
  /// The shader has finished all lanes of the warp's batch; the warp may send its next one.
  virtual void finished(unsigned entry) = 0;
  /// Whether the lane, whose traversal of the round has ended, has hits that the shader has not seen: it then waits for
  /// the part (waiting_any_hit), which finishes it.
  virtual bool holds(LaneId /*id*/) const { return false; }
};

/// Callback of the collector, implemented by the RT scheduler.
class any_hit_client_if : public virtual sc_core::sc_interface {
 public:
  /// The any-hit shader has finished these lanes of a warp. Throws Error if they were not at the shader.
  virtual void any_hit_done(Cycle now, const AnyHitDone& done) = 0;
};

/// Base class of any-hit collectors and any-hit units.
class AnyHitModule : public RtPart, public any_hit_if {
 public:
  sc_core::sc_port<warp_buffer_if> warp_buffer{"warp_buffer"};
  sc_core::sc_port<any_hit_client_if> client{"client"};
  LinkOut<AnyHitBatch> batch{"batch"};
  LinkIn<AnyHitDone> done{"done"};

  /// Receives at most one answer of the shader, then sends at most one batch.
  virtual void invoke(Cycle now) = 0;
  /// Earliest cycle after `now` in which a batch can be sent if no lane changes its state; kNever if none waits.
  virtual Cycle next_due(Cycle now) const = 0;

  /// Counters since the start of the launch.
  virtual AnyHitCounters counters() const = 0;

 protected:
  using RtPart::RtPart;
};

}  // namespace grtx::modules
