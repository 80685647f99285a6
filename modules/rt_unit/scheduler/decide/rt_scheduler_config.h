// SPDX-License-Identifier: Apache-2.0
// Keys and counters of the RT scheduler, and of the warp walk scheduler in its place.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/rt_unit/part/part_info.h"
#include "grtx/modules/rt_unit/scheduler/decide/warp_selection.h"
#include "grtx/modules/rt_unit/warp_buffer/decide/warp_wait.h"

namespace grtx::modules {

struct RtSchedulerConfig {
  std::string policy = "oldest_first";  ///< name of a WarpSelection
  void parameters(ParameterList& list) {
    list.add("policy", policy, warp_selection_names(), "policy that selects the warp of a cycle", kVulkanSim);
  }
};
/// The part's row in the table of all parts.
PartInfo part_info(const RtSchedulerConfig& config);

/// Counters of warps that walk together; 0 if each lane has a stack.
struct WarpWalkCounters {
  std::uint64_t entries = 0;       ///< started, or dropped
  std::uint64_t dropped = 0;       ///< beyond t_max of all their lanes
  std::uint64_t in_vain = 0;       ///< tests of lanes for which the node is beyond t_max
  std::uint64_t under_way = 0;     ///< entries of the warp under way at a start, itself included, summed over starts
  std::uint64_t most_waiting = 0;  ///< most entries of a warp that waited, in memory or not
};

struct RtSchedulerCounters {
  std::uint64_t selections = 0, lanes_handled = 0, lanes_active = 0;
  std::array<std::uint64_t, kStalls> stall{};
  // Trace events executed.
  std::uint64_t visits_internal = 0, visits_instance = 0, visits_leaf = 0, culls = 0;
  std::uint64_t replay_takes = 0, replay_forwards = 0, any_hit_calls = 0, intersection_calls = 0;
  WarpWalkCounters walk;
  std::uint64_t events() const {
    return visits_internal + visits_instance + visits_leaf + culls + replay_takes + replay_forwards;
  }
  double simt_efficiency() const {
    return lanes_active == 0 ? 0.0 : static_cast<double>(lanes_handled) / static_cast<double>(lanes_active);
  }
  static const CounterTable<RtSchedulerCounters>& table();
  void add(const RtSchedulerCounters& other) { table().add(*this, other); }
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};

}  // namespace grtx::modules
