// SPDX-License-Identifier: Apache-2.0
// An RT unit as an SM sees it: its ports, and how to make one (rt_unit.h). Its configuration: rt_unit_config.h.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/node_fetch_messages.h"
#include "grtx/modules/messages/read_at_once_if.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/rt_unit/rt_unit_config.h"
#include "grtx/modules/rt_unit/rt_unit_counters.h"
#include "grtx/modules/rt_unit/rt_unit_parts.h"
#include "grtx/traces/header.h"

namespace grtx::modules {

/// An RT unit as the SM and its observers see it.
class RtUnitModule : public ClockedModule {
 public:
  LinkIn<TraceCall> trace_call{"trace_call"};           ///< from the SIMT core
  LinkOut<TraceDone> trace_done{"trace_done"};          ///< one per call, in any order
  LinkOut<AnyHitBatch> any_hit_batch{"any_hit_batch"};  ///< a warp has at most one batch at the shader
  LinkIn<AnyHitDone> any_hit_done{"any_hit_done"};
  /// L1 client for node fetches; bound when fetches_nodes().
  OptionalLinkOut<MemoryRequest> node_request{"node_request"};
  OptionalLinkIn<MemoryResponse> node_response{"node_response"};
  /// The L1 itself, bound where rt.memory.l1_hit_latency asks it in the cycle of the request.
  OptionalReadAtOnce node_reads{"node_reads"};
  /// To and from the SIMT core; used if the shaders fetch the nodes, i.e. when not fetches_nodes().
  OptionalLinkOut<NodeFetchBatch> node_fetch{"node_fetch"};
  OptionalLinkIn<NodeFetchDone> node_fetch_done{"node_fetch_done"};
  /// L1 client for checkpoint traffic; bound when has_checkpoint().
  OptionalLinkOut<MemoryRequest> checkpoint_request{"checkpoint_request"};
  OptionalLinkIn<MemoryResponse> checkpoint_response{"checkpoint_response"};
  /// L1 client for prefetches; bound when has_prefetcher().
  OptionalLinkOut<MemoryRequest> prefetch_request{"prefetch_request"};
  OptionalLinkIn<MemoryResponse> prefetch_response{"prefetch_response"};
  /// L1 client for stack entries; bound when has_stack().
  OptionalLinkOut<MemoryRequest> stack_request{"stack_request"};
  OptionalLinkIn<MemoryResponse> stack_response{"stack_response"};

  /// Its ports at the L1, under the names of RtUnitConfig::l1_clients().
  struct L1Port {
    const char* client;
    OptionalLinkOut<MemoryRequest>& request;
    OptionalLinkIn<MemoryResponse>& response;
  };
  std::vector<L1Port> l1_ports() {
    std::vector<L1Port> ports;
    if (fetches_nodes()) ports.push_back({"rt_node", node_request, node_response});
    if (has_checkpoint()) ports.push_back({"rt_checkpoint", checkpoint_request, checkpoint_response});
    if (has_prefetcher()) ports.push_back({"rt_prefetch", prefetch_request, prefetch_response});
    if (has_stack()) ports.push_back({"rt_stack", stack_request, stack_response});
    return ports;
  }

  virtual bool has_checkpoint() const = 0;
  virtual bool has_prefetcher() const = 0;
  virtual bool has_stack() const = 0;
  virtual bool fetches_nodes() const = 0;
  /// Whether nothing is inside: no warp, no request, no pending response. Does not consider the links.
  virtual bool idle() const = 0;
  /// Grows whenever the unit makes progress; for a watchdog.
  virtual std::uint64_t progress() const = 0;
  /// Completes the per-cycle counters up to `end` (exclusive). Call before counters().
  virtual void settle(Cycle end) = 0;
  virtual RtUnitCounters counters() const = 0;
  /// First cycle that the per-cycle counters do not cover yet. At the end it may be beyond the last warp's retirement,
  /// if writes or prefetches were still in flight.
  virtual Cycle accounted() const = 0;
  /// Number of cycles so far in which a warp was scheduled.
  virtual std::uint64_t selections() const = 0;
  /// Warps in the warp buffer summed over the cycles before `end`; may be called during a run.
  virtual std::uint64_t warp_cycles_until(Cycle end) const = 0;
  /// The inventories of all parts, in block-diagram order.
  virtual std::vector<Inventory> inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;

 protected:
  using ClockedModule::ClockedModule;
};

/// The project's RT unit. sm: number of the SM, selects its per-ray buffers in the map. map and domain must outlive the
/// unit. parts: factories of its parts. Throws Error for an impossible configuration.
std::unique_ptr<RtUnitModule> make_rt_unit(const sc_core::sc_module_name& name, const RtUnitConfig& config,
                                           const traces::Header& header, const MemoryMap& map, ClockDomain& domain,
                                           unsigned sm, const RtUnitParts& parts = {});

}  // namespace grtx::modules
