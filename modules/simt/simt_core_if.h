// SPDX-License-Identifier: Apache-2.0
// The SIMT core as an SM sees it: its ports, and how to make one (simt_core.h).
#pragma once

#include <iosfwd>
#include <memory>
#include <systemc>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/node_fetch_messages.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/simt/decide/simt_core_config.h"
#include "grtx/traces/header.h"

namespace grtx::modules {

/// The SIMT core as the SM sees it.
class SimtCoreModule : public ClockedModule {
 public:
  /// Ports with one binding per RT unit, in the same number and order for all.
  template <typename Interface>
  using ForEachRtUnit = sc_core::sc_port<Interface, 0>;
  template <typename Interface>
  using ForEachRtUnitOrNone = sc_core::sc_port<Interface, 0, sc_core::SC_ZERO_OR_MORE_BOUND>;

  // Links with room for one message per resident warp never block; smaller ones work, but are polled when full.
  LinkIn<LaunchWarp> launch{"launch"};
  LinkOut<WarpEnded> ended{"ended"};
  // The warp in slot s uses RT unit s mod (number of RT units).
  ForEachRtUnit<link_out_if<TraceCall>> trace_call{"trace_call"};
  ForEachRtUnit<link_in_if<TraceDone>> trace_done{"trace_done"};
  ForEachRtUnit<link_in_if<AnyHitBatch>> any_hit_batch{"any_hit_batch"};
  ForEachRtUnit<link_out_if<AnyHitDone>> any_hit_done{"any_hit_done"};
  /// Bound if the shaders fetch the nodes for the RT units.
  ForEachRtUnitOrNone<link_in_if<NodeFetchBatch>> node_fetch{"node_fetch"};
  ForEachRtUnitOrNone<link_out_if<NodeFetchDone>> node_fetch_done{"node_fetch_done"};
  LinkOut<MemoryRequest> memory_request{"memory_request"};
  LinkIn<MemoryResponse> memory_response{"memory_response"};

  /// Counters up to the clock's current cycle.
  virtual SimtCounters counters() const = 0;
  /// No warp is resident and nothing waits in any queue.
  virtual bool idle() const = 0;
  virtual Inventory inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;

 protected:
  using ClockedModule::ClockedModule;
};

/// The project's SIMT core. `map` must outlive it. Throws Error if the header or the configuration is outside what it
/// can run.
std::unique_ptr<SimtCoreModule> make_simt_core(const sc_core::sc_module_name& name, ClockDomain& domain,
                                               const SimtCoreConfig& config, const traces::Header& header,
                                               const MemoryMap& map);

}  // namespace grtx::modules
