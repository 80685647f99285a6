// SPDX-License-Identifier: Apache-2.0
// Keys and counters of the memory scheduler.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <string>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/modules/rt_unit/part/part_info.h"

namespace grtx::modules {

struct MemorySchedulerConfig {
  unsigned queue = 64;  ///< a warp is scheduled only while kMaxLanes (32) places are free
  bool merge_in_flight = true;
  bool by_shader = false;
  unsigned sectors_per_cycle = 1;
  unsigned l1_hit_latency = kThroughThePort;
  unsigned node_ports = 0;
  bool oldest_warp_first = false;
  NodeTrafficConfig traffic;
  static constexpr unsigned kThroughThePort = static_cast<unsigned>(kMaxLatency);
  /// Whether the L1 is asked in the cycle of the request, not through links.
  bool asks_at_once() const { return l1_hit_latency != kThroughThePort; }
  void parameters(ParameterList& list) {
    list.add("queue", queue, {kMaxLanes, kMaxEntries}, "fetches", "node fetches waiting to be issued", kOurs);
    list.add("merge_in_flight", merge_in_flight, "a fetch also merges with one of its warp that is still under way",
             from_public("Vulkan-Sim: a chunk that returns serves all lanes of the warp at that node"));
    list.add("by_shader", by_shader, "the SIMT core reads the nodes, the RT unit only intersects (as on AMD)",
             from_paper("GRTX, Section IV: the RT unit does"));
    list.add("sectors_per_cycle", sectors_per_cycle, {1, 4}, "sectors/cycle",
             "width of the RT unit's port for nodes at the L1; 4 are the 128 B of recent GPUs", kVulkanSim);
    list.rule(
        "sectors_per_cycle", [this] { return std::has_single_bit(sectors_per_cycle); }, kSectorsRule);
    list.add("l1_hit_latency", l1_hit_latency, {0, kMaxLatency}, "cycles",
             "from the request of a node sector to its data where the L1 holds it, which is looked up in the cycle of "
             "the request; 10000: through a port of the L1, as other reads (l1.latency, l1.link_latency)",
             assumed("10000, a port as others have; Vulkan-Sim: 0"));
    list.rule(
        "l1_hit_latency", [this] { return !asks_at_once() || !by_shader; }, "needs rt.memory.by_shader = false");
    list.add("node_ports", node_ports, {0, kMaxLanes}, "nodes/cycle",
             "nodes that a unit reads in a cycle, of those that have been fetched, each for all tests of it that "
             "start; 0: pipelines read as they start, and of lanes nothing is priced",
             assumed("this project: papers name no ports; designs gautracer and walk have 1"));
    list.add(
        "oldest_warp_first", oldest_warp_first,
        "sectors are issued warp by warp, the oldest first, and of one warp as its fetches were opened; else of all "
        "warps as they were opened. A fetch that has begun is finished",
        assumed("false: a queue in order; Vulkan-Sim takes reads of its oldest warp alone while it has some"));
    traffic.parameters(list);
  }
};
/// The part's row in the table of all parts.
PartInfo part_info(const MemorySchedulerConfig& config, bool walks);

struct MemorySchedulerCounters {
  std::array<std::uint64_t, kRegionCount> visits{};   ///< lane visits
  std::array<std::uint64_t, kRegionCount> fetches{};  ///< after merging
  std::array<std::uint64_t, kRegionCount> sectors{};  ///< requests sent
  std::uint64_t shader_batches = 0;                   ///< by_shader: messages to the SIMT core
  std::uint64_t shader_sectors = 0;                   ///< by_shader: sectors in these messages, equals sum of `sectors`
  Distribution fetch_latency;                         ///< cycles from the first lane's visit to the last sector
  std::uint64_t node_visits() const;
  std::uint64_t node_fetches() const;
  std::uint64_t node_sectors() const;
  static const CounterTable<MemorySchedulerCounters>& table();
  void add(const MemorySchedulerCounters& other) { table().add(*this, other); }
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};

}  // namespace grtx::modules
