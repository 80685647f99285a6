// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/lower_bounds.h"

#include <algorithm>
#include <cmath>

namespace grtx::sim {
namespace {

Cycle divide_up(std::uint64_t work, std::uint64_t rate) { return (work + rate - 1) / rate; }

/// Least cycles of the busiest pipeline: a test occupies it for unit.interval cycles, but nothing waits after the last.
Cycle pipelines(std::uint64_t busy_cycles, const modules::IntersectionConfig& unit) {
  const Cycle busiest = divide_up(busy_cycles, unit.count);
  return busiest - std::min<Cycle>(busiest, unit.interval - 1);
}

}  // namespace

std::vector<LowerBound> chain_bounds(const Chain& longest) {
  return {{"longest_ray", longest.ray, "longest ray: its visits, any-hit calls and rounds at least latency", true},
          {"longest_warp", longest.warp, "longest warp: its rounds, each as long as its longest lane", true}};
}

std::vector<LowerBound> lower_bounds(const GpuCounters& c, const Chain& longest, const GpuConfig& config) {
  Cycle issue = 0, simt = 0, box = 0, triangle = 0, sphere = 0, gaussian = 0, transform = 0, rt_port = 0, l1_port = 0;
  for (const modules::RtUnitCounters& rt : c.rt_of) {
    issue = std::max(issue, rt.scheduler.selections);
    box = std::max(box, pipelines(rt.ray_box.busy_cycles, config.rt.ray_box));
    triangle = std::max(triangle, pipelines(rt.ray_triangle.busy_cycles, config.rt.ray_triangle));
    sphere = std::max(sphere, pipelines(rt.ray_sphere.busy_cycles, config.rt.ray_sphere));
    gaussian = std::max(gaussian, pipelines(rt.ray_gaussian.busy_cycles, config.rt.ray_gaussian));
    transform = std::max(transform, pipelines(rt.ray_transform.busy_cycles, config.rt.ray_transform));
    rt_port = std::max(rt_port, divide_up(rt.memory.node_sectors(), config.rt.memory.sectors_per_cycle));
  }
  for (const modules::SimtCounters& core : c.simt_of) {
    simt = std::max(simt, divide_up(core.issue_busy_cycles, config.simt.schedulers));
  }
  for (const modules::L1Counters& l1 : c.l1_of) l1_port = std::max(l1_port, divide_up(l1.accesses(), config.l1.banks));
  Cycle l1_miss_port = 0, l2_port = 0;
  for (const modules::L1Counters& l1 : c.l1_of) l1_miss_port = std::max(l1_miss_port, l1.sent_reads + l1.sent_writes);
  for (const modules::L2Counters& l2 : c.l2_of) l2_port = std::max(l2_port, l2.accesses());
  const auto dram = static_cast<Cycle>(std::floor(c.memory.busy_cycles));
  std::vector<LowerBound> bounds = {
      {"issue", issue, "cycles in which the busiest RT unit scheduled a warp"},
      {"simt_issue", simt, "instructions of the busiest SIMT core over its warp schedulers"},
      {"unit.box", box, "busiest ray-box units: tests x interval / count"},
      {"unit.triangle", triangle, "busiest ray-triangle units"},
      {"unit.sphere", sphere, "busiest ray-sphere units"},
      {"unit.gaussian", gaussian, "busiest ray-Gaussian units"},
      {"unit.transform", transform, "busiest ray-transform units"},
      {"rt_port", rt_port, "node sectors of the busiest RT unit over the width of its port"},
      {"l1_port", l1_port, "accesses of the busiest L1 over its banks"},
      {"l1_miss_port", l1_miss_port, "misses and writes of the busiest L1, one a cycle"},
      {"l2_port", l2_port, "accesses of the busiest L2 slice, one a cycle"},
      {"dram_bandwidth", dram, "bursts of the busiest DRAM channel on its data bus"}};
  const std::vector<LowerBound> chains = chain_bounds(longest);
  bounds.insert(bounds.end(), chains.begin(), chains.end());
  return bounds;
}

const LowerBound& binding_bound(const std::vector<LowerBound>& bounds) {
  return *std::max_element(bounds.begin(), bounds.end(),
                           [](const LowerBound& a, const LowerBound& b) { return a.cycles < b.cycles; });
}

void describe(const std::vector<LowerBound>& bounds, Cycle cycles, modules::StatisticList& list) {
  for (const LowerBound& bound : bounds) {
    list.add(kBoundPrefix + bound.name, bound.cycles, "cycles", "lower bound: " + bound.description,
             modules::StatisticKind::bound);
  }
  const LowerBound& binding = binding_bound(bounds);
  list.add("gpu.bound.largest", binding.cycles, "cycles", "largest lower bound: " + binding.name,
           modules::StatisticKind::bound);
  list.add("gpu.bound.fraction", cycles == 0 ? 0.0 : static_cast<double>(binding.cycles) / static_cast<double>(cycles),
           "ratio", "largest lower bound / gpu.cycles");
}

}  // namespace grtx::sim
