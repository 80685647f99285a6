// SPDX-License-Identifier: Apache-2.0
// Keys and counters of the warp buffer.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/rt_unit/part/part_info.h"
#include "grtx/modules/rt_unit/stack/decide/stack_entry.h"
#include "grtx/modules/rt_unit/warp_buffer/decide/warp_wait.h"

namespace grtx::modules {

struct WarpBufferConfig {
  unsigned entries = 8;
  unsigned stack_entries = 8;
  bool spill = true;  ///< needs the StackUnit
  unsigned ray_banks = 0;
  /// Stack entries of a lane in the warp buffer.
  unsigned on_chip_entries(unsigned bvh_width) const {
    return spill ? stack_entries : std::max(stack_entries, deepest_stack(bvh_width));
  }
  void parameters(ParameterList& list) {
    list.add("entries", entries, {1, 64}, "warps", "warp buffer of the RT unit", kTable1);
    list.add("stack_entries", stack_entries, {1, 1024}, "entries",
             "traversal stack of a lane in the warp buffer; deeper ones spill", kOurs);
    list.add("spill", spill,
             "stack entries beyond the warp buffer are written to memory and read back; else there is room for the "
             "deepest stack (140 entries with nodes of 6 children)",
             kOurs);
    list.add(
        "ray_banks", ray_banks, {0, kMaxLanes}, "banks",
        "each unit that reads rays has a copy of them, with lane l in bank l mod so many, and reads each bank once "
        "a cycle; 0: pipelines read as they start, and one port is priced",
        assumed("this project: papers name no ports; designs gautracer and walk have 4"));
    list.rule(
        "stack_entries", [this] { return !spill || stack_entries >= 2; },
        "must be at least 2 with rt.warp_buffer.spill");
  }
};
/// The part's row in the table of all parts.
PartInfo part_info(const WarpBufferConfig& config);

/// Counters of a warp buffer.
struct WarpBufferCounters {
  std::uint64_t calls = 0;               ///< traceRay calls accepted
  std::uint64_t occupancy_integral = 0;  ///< warps x cycles
  std::uint64_t max_stack_depth = 0;
  std::array<std::uint64_t, kWarpWaits> warp_cycles{};  ///< [WarpWait] warps x cycles
  Distribution warp_latency;                            ///< cycles from acceptance to retirement
  static const CounterTable<WarpBufferCounters>& table();
  void add(const WarpBufferCounters& other) { table().add(*this, other); }
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};

}  // namespace grtx::modules
