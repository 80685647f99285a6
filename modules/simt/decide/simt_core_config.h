// SPDX-License-Identifier: Apache-2.0
// Keys and counters of an SM's SIMT core; counters of several SMs are summed.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <string_view>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/hit_heap.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/simt/decide/register_file.h"
#include "grtx/modules/simt/decide/shader_costs.h"

namespace grtx::modules {

struct SimtCoreConfig {
  unsigned sm = 0;  ///< index of the SM, for the addresses of its per-ray buffers
  unsigned schedulers = 4;
  unsigned resident_warps = 32;  ///< warp slots; must equal MemoryMapConfig's; set by the assembly
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

/// Activity of a resident warp in a cycle; exactly one of these.
enum class WarpActivity : std::uint8_t {
  raygen,   ///< prologue, evict move, trace call, sort or epilogue: waiting for its issue slot or executing
  blend,    ///< the same for the blending phase
  any_hit,  ///< the same for the any-hit and intersection shaders
  memory,   ///< any phase: waiting for its loads
  trace,    ///< in the RT unit, no shader running for it
  fetch,    ///< node fetch for the RT unit (if shaders fetch nodes): waiting for its issue slot or executing
  drain,    ///< finished except for the acknowledgements of its stores
};
constexpr auto enum_names(WarpActivity) {
  return names_in_order<WarpActivity>({"raygen", "blend", "any_hit", "memory", "trace", "fetch", "drain"});
}
inline constexpr std::size_t kWarpActivities = kCountOf<WarpActivity>;
/// Activity of a warp that executes a phase or waits for its issue slot.
constexpr WarpActivity activity_of(PhaseKind kind) {
  if (kind == PhaseKind::blend) return WarpActivity::blend;
  if (kind == PhaseKind::any_hit || kind == PhaseKind::intersection) return WarpActivity::any_hit;
  if (kind == PhaseKind::node_fetch) return WarpActivity::fetch;
  return WarpActivity::raygen;
}

struct LoadStoreCounters {
  std::array<std::uint64_t, kRegionCount> loads{};   ///< sectors
  std::array<std::uint64_t, kRegionCount> stores{};  ///< sectors
  std::uint64_t blocked_cycles = 0;                  ///< ticks with a request waiting but no room in the L1's link
  std::uint64_t deepest_queue = 0;                   ///< most sectors waiting at a time

  std::uint64_t sectors() const;
};

struct SimtCounters {
  std::uint64_t warps = 0;                                   ///< warps that ended
  std::array<std::uint64_t, kPhaseKinds> instructions{};     ///< warp instructions
  std::array<std::uint64_t, kPhaseKinds> phases{};           ///< phases executed
  std::array<std::uint64_t, kWarpActivities> warp_cycles{};  ///< resident warps summed over cycles, by activity
  std::uint64_t issue_busy_cycles = 0;                       ///< issue slots used, all schedulers
  std::uint64_t issue_wait_cycles = 0;                       ///< cycles that phases waited for their scheduler
  ShaderCounters shader;
  LoadStoreCounters memory;
  OwnCounts own;  ///< extra counters of a user-supplied core

  static const CounterTable<SimtCounters>& table();
  void add(const SimtCounters& o) { table().add(*this, o); }
  std::uint64_t all_instructions() const;
  std::uint64_t resident_warp_cycles() const;  ///< occupancy integral: sum of warp_cycles
};

/// Appends all counters as prefix + ".name".
void describe(const SimtCounters& counters, StatisticList& list, const std::string& prefix);

}  // namespace grtx::modules
