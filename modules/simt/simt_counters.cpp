#include "grtx/modules/simt/simt_counters.h"

#include <numeric>

namespace grtx::modules {

void SimtCounters::add(const SimtCounters& o) {
  warps += o.warps;
  for (std::size_t i = 0; i < kPhaseKinds; ++i) {
    instructions[i] += o.instructions[i];
    phases[i] += o.phases[i];
  }
  for (std::size_t i = 0; i < kWarpActivities; ++i) warp_cycles[i] += o.warp_cycles[i];
  issue_busy_cycles += o.issue_busy_cycles;
  issue_wait_cycles += o.issue_wait_cycles;
  shader.add(o.shader);
  memory.add(o.memory);
}

std::uint64_t SimtCounters::all_instructions() const {
  return std::accumulate(instructions.begin(), instructions.end(), std::uint64_t{0});
}

std::uint64_t SimtCounters::resident_warp_cycles() const {
  return std::accumulate(warp_cycles.begin(), warp_cycles.end(), std::uint64_t{0});
}

void describe(const SimtCounters& c, StatisticList& list, const std::string& prefix) {
  const auto add = [&](const std::string& name, std::uint64_t value, const char* unit, std::string description) {
    list.add(prefix + "." + name, value, unit, std::move(description));
  };
  add("warps", c.warps, "warps", "warps (ray groups) that ran to their end");
  add("rounds", c.shader.warp_rounds, "rounds", "traceRay calls of warps");
  add("ray_rounds", c.shader.ray_rounds, "rounds", "rounds of rays executed");
  add("any_hit.batches", c.shader.any_hit_batches, "batches", "any-hit shader invocations of warps");
  add("any_hit.calls", c.shader.any_hit_calls, "calls", "any-hit shader calls of lanes");
  add("evictions", c.shader.evictions, "entries", "entries the any-hit shader wrote to eviction buffers");
  add("eviction_moves", c.shader.eviction_moves, "entries", "entries moved from eviction buffers to k-buffers");
  add("processed", c.shader.entries_processed, "entries", "k-buffer entries looked at when blending");
  add("blended", c.shader.entries_blended, "entries", "k-buffer entries blended");
  add("k_buffer_mismatches", c.shader.k_buffer_mismatches, "rounds",
      "ray rounds whose any-hit calls do not add up to the k-buffer of the trace; 0 in a correct run");
  add("instructions.total", c.all_instructions(), "instructions", "warp instructions issued");
  for (std::size_t i = 0; i < kPhaseKinds; ++i) {
    const std::string kind(kPhaseKindNames[i]);
    add("instructions." + kind, c.instructions[i], "instructions", "warp instructions of phase " + kind);
  }
  for (std::size_t i = 0; i < kPhaseKinds; ++i) {
    const std::string kind(kPhaseKindNames[i]);
    add("phases." + kind, c.phases[i], "phases", "executions of phase " + kind);
  }
  add("issue.busy_cycles", c.issue_busy_cycles, "cycles", "issue slots used, summed over warp schedulers");
  add("issue.wait_cycles", c.issue_wait_cycles, "cycles", "cycles that phases waited for their warp scheduler");
  add("resident_warp_cycles", c.resident_warp_cycles(), "cycles", "resident warps summed over cycles");
  for (std::size_t i = 0; i < kWarpActivities; ++i) {
    const std::string name(kWarpActivityNames[i]);
    add("warp_cycles." + name, c.warp_cycles[i], "cycles", "resident warps in state " + name + ", summed over cycles");
  }
  add("lsu.sectors", c.memory.sectors(), "sectors", "32 B sector requests sent to the L1");
  for (std::size_t r = 0; r < kRegionCount; ++r) {
    const std::string region(kRegionNames[r]);
    if (is_node(static_cast<Region>(r)) || static_cast<Region>(r) == Region::checkpoint ||
        static_cast<Region>(r) == Region::stack) {
      continue;  // RT unit's traffic
    }
    add("lsu.loads." + region, c.memory.loads[r], "sectors", "sectors loaded from region " + region);
    add("lsu.stores." + region, c.memory.stores[r], "sectors", "sectors stored to region " + region);
  }
  add("lsu.load_instructions", c.shader.load_instructions, "instructions", "warp load instructions");
  add("lsu.store_instructions", c.shader.store_instructions, "instructions", "warp store instructions");
  add("lsu.blocked_cycles", c.memory.blocked_cycles, "cycles", "cycles in which the L1 took no request that waited");
  add("lsu.deepest_queue", c.memory.deepest_queue, "sectors", "most sectors that waited in one load-store unit");
}

}  // namespace grtx::modules
