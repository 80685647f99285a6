// SPDX-License-Identifier: Apache-2.0
// Interface through which the RT scheduler tells a prefetcher of its visits. Nobody waits for the prefetcher.
#pragma once

#include <cstdint>
#include <systemc>

#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/rt_unit/part/rt_part.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

struct PrefetchCounters;

/// The RT scheduler's view of a prefetcher.
class prefetch_if : public virtual sc_core::sc_interface {
 public:
  /// A lane begins a round of the ray in warp slot `slot`. replays: it resumes from its source entries.
  virtual void begin_lane(LaneId id, std::uint16_t slot, bool replays) = 0;
  /// Starts the visits of one warp in one cycle.
  virtual void begin_warp() = 0;
  /// The lane visited group.nodes[definition]: it hit the children in `hit` and checkpointed those in `checkpointed`.
  virtual void note_internal(LaneId id, const traces::RayGroup& group, std::uint32_t definition, unsigned hit,
                             unsigned checkpointed) = 0;
  /// The lane has taken a source entry that names the node at `address` (in units).
  virtual void note_replayed(LaneId id, std::uint32_t address) = 0;
  /// The lane visits the leaf at `address` (in units).
  virtual void note_leaf(LaneId id, const traces::RayGroup& group, std::uint32_t address) = 0;
};

/// Base class of node prefetchers.
class PrefetchModule : public RtMemoryPart, public prefetch_if {
 public:
  LinkOut<MemoryRequest> request{"request"};
  LinkIn<MemoryResponse> response{"response"};

  /// Counters since the start of the launch.
  virtual PrefetchCounters counters() const = 0;

 protected:
  using RtMemoryPart::RtMemoryPart;
};

}  // namespace grtx::modules
