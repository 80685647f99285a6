// SPDX-License-Identifier: Apache-2.0
// Interfaces of the warp buffer. The state of all warps is one table that all parts of the RT unit access, like a
// register file.
#pragma once

#include <systemc>

#include "grtx/base/strong.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/rt_unit/part/rt_part.h"

namespace grtx::modules {

struct WarpBufferCounters;
class WarpTable;

/// The other parts' view of the warp buffer.
class warp_buffer_if : public virtual sc_core::sc_interface {
 public:
  /// The state of the warps. Looked up once, at the end of elaboration; its address does not change.
  virtual WarpTable& warps() = 0;
};

/// Callback for a call that has entered the buffer, implemented by the RT scheduler, which prepares the other parts.
class warp_admission_if : public virtual sc_core::sc_interface {
 public:
  /// The lanes of `entry` are at the first event of their round. Called once per call, in the cycle of its acceptance.
  virtual void begin(unsigned entry) = 0;
};

/// Base class of warp buffers: accepts calls and retires warps whose lanes have all finished.
class WarpBufferModule : public RtPart, public warp_buffer_if {
 public:
  LinkIn<TraceCall> trace_call{"trace_call"};
  LinkOut<TraceDone> trace_done{"trace_done"};
  sc_core::sc_port<warp_admission_if> admission{"admission"};

  /// Retires at most one warp.
  virtual void retire(Cycle now) = 0;
  /// Accepts at most one call, if there is room.
  virtual void accept(Cycle now) = 0;
  /// Completes the per-cycle counters up to `end` (exclusive).
  virtual void settle(Cycle end) = 0;

  /// Counters since the start of the launch.
  virtual WarpBufferCounters counters() const = 0;

 protected:
  using RtPart::RtPart;
};

}  // namespace grtx::modules
