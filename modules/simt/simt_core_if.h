// The SIMT core as an SM sees it: warps in from the work distributor, calls out to the RT units, loads and stores.
#pragma once

#include <iosfwd>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/node_fetch_messages.h"
#include "grtx/modules/messages/warp_messages.h"

namespace grtx::modules {

struct SimtCounters;

class SimtCoreModule : public ClockedModule {
 public:
  /// One binding an RT unit, the same number and order for all.
  template <typename Interface>
  using ForEachRtUnit = sc_core::sc_port<Interface, 0>;
  template <typename Interface>
  using ForEachRtUnitOrNone = sc_core::sc_port<Interface, 0, sc_core::SC_ZERO_OR_MORE_BOUND>;

  // Links to hold one message per resident warp never block; smaller ones are correct, but are polled when full.
  LinkIn<LaunchWarp> launch{"launch"};
  LinkOut<WarpEnded> ended{"ended"};
  // The warp in slot s belongs to RT unit s mod their number.
  ForEachRtUnit<link_out_if<TraceCall>> trace_call{"trace_call"};
  ForEachRtUnit<link_in_if<TraceDone>> trace_done{"trace_done"};
  ForEachRtUnit<link_in_if<AnyHitBatch>> any_hit_batch{"any_hit_batch"};
  ForEachRtUnit<link_out_if<AnyHitDone>> any_hit_done{"any_hit_done"};
  /// Bound when the shaders fetch the nodes for the RT units.
  ForEachRtUnitOrNone<link_in_if<NodeFetchBatch>> node_fetch{"node_fetch"};
  ForEachRtUnitOrNone<link_out_if<NodeFetchDone>> node_fetch_done{"node_fetch_done"};
  LinkOut<MemoryRequest> memory_request{"memory_request"};
  LinkIn<MemoryResponse> memory_response{"memory_response"};

  /// Counters up to the clock's present cycle.
  virtual SimtCounters counters() const = 0;
  /// No warp is resident and nothing waits in any queue.
  virtual bool idle() const = 0;
  virtual Inventory inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;

 protected:
  using ClockedModule::ClockedModule;
};

}  // namespace grtx::modules
