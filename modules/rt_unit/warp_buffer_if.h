// The warp buffer and those who read and write it: the state of all warps is one table, which every part of the RT unit
// sees as it would see a register file.
#pragma once

#include <systemc>

#include "grtx/base/strong.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/rt_unit/rt_part.h"

namespace grtx::modules {

struct WarpBufferCounters;
class WarpTable;

/// What the other parts see of the warp buffer.
class warp_buffer_if : public virtual sc_core::sc_interface {
 public:
  /// The state of the warps. Looked up once, after elaboration; it stays where it is.
  virtual WarpTable& warps() = 0;
};

/// Who prepares the other parts for a call that has entered the buffer: the RT scheduler.
class warp_admission_if : public virtual sc_core::sc_interface {
 public:
  /// The lanes of `entry` stand at the first event of their round. Called once a call, in the cycle of its acceptance.
  virtual void begin(unsigned entry) = 0;
};

/// A warp buffer: takes calls in and retires warps whose lanes have all finished.
class WarpBufferModule : public RtPart, public warp_buffer_if {
 public:
  LinkIn<TraceCall> trace_call{"trace_call"};
  LinkOut<TraceDone> trace_done{"trace_done"};
  sc_core::sc_port<warp_admission_if> admission{"admission"};

  /// Retires at most one warp.
  virtual void retire(Cycle now) = 0;
  /// Takes at most one call, if there is room.
  virtual void accept(Cycle now) = 0;
  /// Closes per-cycle counts at `end`, the first cycle that does not count.
  virtual void settle(Cycle end) = 0;

  /// What it has counted since the launch began.
  virtual WarpBufferCounters counters() const = 0;

 protected:
  using RtPart::RtPart;
};

}  // namespace grtx::modules
