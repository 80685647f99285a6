// An RT unit as an SM sees it: ports to the SIMT core and to the L1, and what the SM and its observers ask.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <vector>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/node_fetch_messages.h"
#include "grtx/modules/messages/warp_messages.h"

namespace grtx::modules {

struct RtUnitCounters;

class RtUnitModule : public ClockedModule {
 public:
  LinkIn<TraceCall> trace_call{"trace_call"};           ///< from the SIMT core
  LinkOut<TraceDone> trace_done{"trace_done"};          ///< one for each call, in any order
  LinkOut<AnyHitBatch> any_hit_batch{"any_hit_batch"};  ///< a warp has at most one batch at the shader
  LinkIn<AnyHitDone> any_hit_done{"any_hit_done"};
  /// L1 client for node fetches, unless the shader cores fetch the nodes (fetches_nodes()).
  OptionalLinkOut<MemoryRequest> node_request{"node_request"};
  OptionalLinkIn<MemoryResponse> node_response{"node_response"};
  /// To the SIMT core and back; used when the shader cores fetch.
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

  virtual bool has_checkpoint() const = 0;
  virtual bool has_prefetcher() const = 0;
  virtual bool has_stack() const = 0;
  virtual bool fetches_nodes() const = 0;
  /// Nothing inside: no warp, no request, no response due. Links are not looked at.
  virtual bool idle() const = 0;
  /// Grows with all that the unit does; for a watchdog.
  virtual std::uint64_t progress() const = 0;
  /// Closes per-cycle counts at `end`, the first cycle that does not count. Call before counters().
  virtual void settle(Cycle end) = 0;
  virtual RtUnitCounters counters() const = 0;
  /// First cycle that per-cycle counts do not cover yet; after the last warp it may lie beyond the cycle of retirement,
  /// when writes or prefetches were still under way.
  virtual Cycle accounted() const = 0;
  /// Cycles in which a warp was scheduled, so far.
  virtual std::uint64_t selections() const = 0;
  /// Warps in the warp buffer summed over the cycles before `end`, of a running unit.
  virtual std::uint64_t warp_cycles_until(Cycle end) const = 0;
  /// The inventories of all parts, in block-diagram order.
  virtual std::vector<Inventory> inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;

 protected:
  using ClockedModule::ClockedModule;
};

}  // namespace grtx::modules
