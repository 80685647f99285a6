// SPDX-License-Identifier: Apache-2.0
// Interface between the RT scheduler and the checkpoint unit: writing and replaying checkpoint entries.
#pragma once

#include <cstdint>
#include <systemc>

#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/rt_unit/part/rt_part.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

struct CheckpointCounters;

/// The RT scheduler's view of the checkpoint unit.
class checkpoint_if : public virtual sc_core::sc_interface {
 public:
  /// A lane begins round `round` in warp slot `slot`. replays: it resumes from its source entries. source_entries:
  /// their number if needs_source_entries(), else 0. ray: the lane's ray; its bins say where its entries go.
  virtual void begin_lane(LaneId id, std::uint16_t slot, std::uint32_t round, bool replays,
                          std::uint32_t source_entries, const traces::Ray& ray) = 0;
  /// Whether begin_lane() needs the number of source entries, because the buffer is read from its end.
  virtual bool needs_source_entries() const = 0;
  /// The lane has `entries` entries to write and, if `last`, no further event in the round. Returns whether the lane
  /// must wait; if so, entries_taken() is called when all are accepted.
  virtual bool submit(LaneId id, unsigned entries, bool last) = 0;
  /// The lane needs its next source entry. Returns whether it is available at once; if not, entry_read() is called
  /// later.
  virtual bool read(LaneId id) = 0;
};

/// Callbacks of the checkpoint unit, implemented by the RT scheduler.
class checkpoint_client_if : public virtual sc_core::sc_interface {
 public:
  /// The lane's source entry has been read.
  virtual void entry_read(LaneId id) = 0;
  /// The lane's entries (and, at the end of a round, its open sectors) have been accepted.
  virtual void entries_taken(LaneId id) = 0;
};

/// Base class of checkpoint units.
class CheckpointModule : public RtMemoryPart, public checkpoint_if {
 public:
  sc_core::sc_port<checkpoint_client_if> client{"client"};
  LinkOut<MemoryRequest> request{"request"};
  LinkIn<MemoryResponse> response{"response"};

  /// Accepts submitted entries while there is room.
  virtual void accept(Cycle now) = 0;

  /// Counters since the start of the launch.
  virtual CheckpointCounters counters() const = 0;

 protected:
  using RtMemoryPart::RtMemoryPart;
};

}  // namespace grtx::modules
