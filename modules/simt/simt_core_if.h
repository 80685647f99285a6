// SPDX-License-Identifier: Apache-2.0
// The SIMT core as an SM sees it: its ports, its configuration, and how to make one (simt_core.h).
#pragma once

#include <bit>
#include <cstdint>
#include <iosfwd>
#include <memory>
#include <systemc>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/hit_heap.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/node_fetch_messages.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/simt/decide/shader_costs.h"
#include "grtx/modules/simt/register_file.h"
#include "grtx/modules/simt/simt_counters.h"
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

struct SimtCoreConfig {
  unsigned sm = 0;  ///< index of the SM, for the addresses of its per-ray buffers
  unsigned schedulers = 4;
  unsigned resident_warps = 32;  ///< warp slots, at most 64; must equal MemoryMapConfig's; set by the assembly
  unsigned instruction_latency = 4;
  std::uint8_t l1_client = 1;  ///< L1 port of the load-store unit; set by the assembly
  RegisterFile register_file;
  unsigned sectors_per_cycle = 1;
  RayArrayLayout k_buffer_layout = RayArrayLayout::by_lane;  ///< both are passed to the MemoryMap by the assembly
  RayArrayLayout eviction_layout = RayArrayLayout::by_ray;
  ShaderCosts costs;
  HitHeap heap{};  ///< of the RT unit's any-hit unit; set by the assembly
  /// All but the costs, which are a table of their own.
  void parameters(ParameterList& list) {
    list.add("schedulers", schedulers, {1, 64}, "schedulers", "warp schedulers of an SM", kTable1);
    list.add("instruction_latency", instruction_latency, {0, kMaxLatency}, "cycles",
             "from issue of an instruction to its result", assumed("common GPU ALU latency"));
    list.add("sectors_per_cycle", sectors_per_cycle, {1, 4}, "sectors/cycle",
             "width of the load-store unit and of its port at the L1", kOurs);
    list.add("dependent_loads", costs.dependent_loads,
             "the any-hit shader's loop over the k-buffer waits for each load before the next iteration; else all its "
             "loads are sent at once",
             kOurs);
    list.add("k_buffer_layout", k_buffer_layout,
             "entry i of a warp's k-buffers side by side over its lanes, t and id apart, or a ray's entries together",
             assumed("CUDA: local memory is interleaved over the threads of a warp"));
    list.add("eviction_layout", eviction_layout, "the same for eviction buffers", kOurs);
    list.add("eviction_traffic", costs.eviction_traffic,
             "whether hits that fall out of a k-buffer are written to memory and read back; uncharged is an "
             "assumption, not hardware",
             kOurs);
    list.add("list_batch", costs.list_batch, {1, 64}, "hits",
             "list: nearest hits that a scan of a ray's list keeps in registers, sorted, for blending",
             from_public("GRay, cuda/forward_pass.cu"));
    register_file.parameters(list);
    list.rule(
        "sectors_per_cycle", [this] { return std::has_single_bit(sectors_per_cycle); }, kSectorsRule);
  }
};

/// The project's SIMT core. `map` must outlive it. Throws Error if the header or the configuration is outside what it
/// can run.
std::unique_ptr<SimtCoreModule> make_simt_core(const sc_core::sc_module_name& name, ClockDomain& domain,
                                               const SimtCoreConfig& config, const traces::Header& header,
                                               const MemoryMap& map);

}  // namespace grtx::modules
