// Between the RT scheduler, which finds hits, and the any-hit collector, which has the shader called for them.
#pragma once

#include <systemc>

#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/rt_unit/rt_part.h"
#include "grtx/modules/rt_unit/warp_buffer_if.h"

namespace grtx::modules {

struct AnyHitCounters;

/// The RT scheduler's view of the collector.
class any_hit_if : public virtual sc_core::sc_interface {
 public:
  /// The lane, now in an intersection unit, has a hit for the any-hit shader.
  virtual void arrive(Cycle now, LaneId id) = 0;
  /// The shader has finished all lanes of the warp's batch; the warp may send its next one.
  virtual void finished(unsigned entry) = 0;
};

/// Who goes on with the lanes.
class any_hit_client_if : public virtual sc_core::sc_interface {
 public:
  /// The any-hit shader has finished these lanes of a warp. Throws Error when they were not at the shader.
  virtual void any_hit_done(const AnyHitDone& done) = 0;
};

/// An any-hit collector.
class AnyHitModule : public RtPart, public any_hit_if {
 public:
  sc_core::sc_port<warp_buffer_if> warp_buffer{"warp_buffer"};
  sc_core::sc_port<any_hit_client_if> client{"client"};
  LinkOut<AnyHitBatch> batch{"batch"};
  LinkIn<AnyHitDone> done{"done"};

  /// Takes at most one answer of the shader, then sends at most one batch.
  virtual void invoke(Cycle now) = 0;
  /// Earliest cycle after `now` in which a batch can be sent if no lane changes its state; kNever: none waits.
  virtual Cycle next_due(Cycle now) const = 0;

  /// What it has counted since the launch began.
  virtual AnyHitCounters counters() const = 0;

 protected:
  using RtPart::RtPart;
};

}  // namespace grtx::modules
