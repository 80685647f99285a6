// SPDX-License-Identifier: Apache-2.0
// Counters of an SM's SIMT core; those of several SMs are summed.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/simt/decide/shader_costs.h"

namespace grtx::modules {

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
