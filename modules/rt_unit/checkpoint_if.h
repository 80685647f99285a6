// Between the RT scheduler and the checkpoint unit: entries to write, entries to replay.
#pragma once

#include <cstdint>
#include <systemc>

#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/rt_unit/rt_part.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

struct CheckpointCounters;

/// The RT scheduler's view of the checkpoint unit.
class checkpoint_if : public virtual sc_core::sc_interface {
 public:
  /// A lane begins round `round` in resident slot `slot`. replays: it resumes from its source entries. source_entries:
  /// how many they are (if needs_source_entries(), else 0). ray: the lane's, whose bins tell where its entries go.
  virtual void begin_lane(LaneId id, std::uint16_t slot, std::uint32_t round, bool replays,
                          std::uint32_t source_entries, const traces::Ray& ray) = 0;
  /// begin_lane() must be told how many source entries there are: the buffer is read from its end.
  virtual bool needs_source_entries() const = 0;
  /// The lane has `entries` entries to write and, if `last`, no further event in the round. Returns whether it must
  /// wait; then entries_taken() names the lane when all is taken.
  virtual bool submit(LaneId id, unsigned entries, bool last) = 0;
  /// The lane needs its next source entry. Returns whether it is there already; else entry_read() names it later.
  virtual bool read(LaneId id) = 0;

  // Functional entries (RtMemoryPart::has_touch()): as read() and submit(), without time, in cycle `at`.
  virtual void touch_read(LaneId /*id*/, Cycle /*at*/) {}
  virtual void touch_submit(LaneId /*id*/, unsigned /*entries*/, bool /*last*/, Cycle /*at*/) {}
};

/// Who goes on with the lanes.
class checkpoint_client_if : public virtual sc_core::sc_interface {
 public:
  /// The lane's source entry is there.
  virtual void entry_read(LaneId id) = 0;
  /// The lane's entries (and open sectors) are handed over.
  virtual void entries_taken(LaneId id) = 0;
};

/// A checkpoint unit.
class CheckpointModule : public RtMemoryPart, public checkpoint_if {
 public:
  sc_core::sc_port<checkpoint_client_if> client{"client"};
  LinkOut<MemoryRequest> request{"request"};
  LinkIn<MemoryResponse> response{"response"};

  /// Takes submitted entries while there is room.
  virtual void accept(Cycle now) = 0;

  /// What it has counted since the launch began.
  virtual CheckpointCounters counters() const = 0;

 protected:
  using RtMemoryPart::RtMemoryPart;
};

}  // namespace grtx::modules
