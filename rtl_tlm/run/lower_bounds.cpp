// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/lower_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <variant>

#include "grtx/modules/rt_unit/rt_unit_table.h"

namespace grtx::sim {
namespace {

Cycle divide_up(std::uint64_t work, std::uint64_t rate) { return (work + rate - 1) / rate; }

/// By PartBound::Limit.
using BoundsByLimit = std::array<std::vector<LowerBound>, 3>;

/// Adds bounds of the RT unit's parts, each that of the busiest unit.
void add_bounds_of_parts(const GpuCounters& c, const GpuConfig& config, BoundsByLimit& bounds) {
  std::vector<std::unordered_map<std::string, std::uint64_t>> counted;  // [RT unit], by name
  for (const modules::RtUnitCounters& rt : c.rt_of) {
    modules::StatisticList list;
    rt.describe(list, "gpu.rt", c.cycles);
    auto& counts = counted.emplace_back();
    for (const modules::Statistic& statistic : list.items()) {
      if (const auto* count = std::get_if<std::uint64_t>(&statistic.value)) counts[statistic.name] = *count;
    }
  }
  for (const modules::PartInfo& part : modules::part_table(config.rt, config.own)) {
    for (const modules::PartBound& bound : part.bounds) {
      Cycle most = 0;
      for (auto& counts : counted) {
        std::uint64_t work = 0;
        for (const std::string& name : bound.statistics) work += counts[name];  // 0: the part counted nothing
        const Cycle cycles = divide_up(work, bound.rate);
        most = std::max(most, cycles - std::min<Cycle>(cycles, bound.drain));
      }
      bounds[static_cast<std::size_t>(bound.limit)].push_back({bound.name, most, bound.description});
    }
  }
}

}  // namespace

std::vector<LowerBound> chain_bounds(const Chain& longest) {
  return {{"longest_ray", longest.ray, "longest ray: its visits, any-hit calls and rounds at least latency", true},
          {"longest_warp", longest.warp, "longest warp: its rounds, each as long as its longest lane", true}};
}

std::vector<LowerBound> lower_bounds(const GpuCounters& c, const Chain& longest, const GpuConfig& config) {
  Cycle simt = 0, l1_port = 0, l1_miss_port = 0, l2_port = 0;
  for (const modules::SimtCounters& core : c.simt_of) {
    simt = std::max(simt, divide_up(core.issue_busy_cycles, config.simt.schedulers));
  }
  for (const modules::L1Counters& l1 : c.l1_of) {
    const std::uint64_t without_bank = config.rt.memory.asks_at_once() ? l1.nodes().reads : 0;
    l1_port = std::max(l1_port, divide_up(l1.accesses() - without_bank, config.l1.banks));
  }
  for (const modules::L1Counters& l1 : c.l1_of) l1_miss_port = std::max(l1_miss_port, l1.sent_reads + l1.sent_writes);
  for (const modules::L2Counters& l2 : c.l2_of) l2_port = std::max(l2_port, l2.accesses());
  const auto dram = static_cast<Cycle>(std::floor(c.memory.busy_cycles));
  BoundsByLimit by_limit;
  add_bounds_of_parts(c, config, by_limit);
  auto& [issue, units, ports] = by_limit;
  issue.push_back({"simt_issue", simt, "instructions of the busiest SIMT core over its warp schedulers"});
  std::vector<LowerBound> bounds;
  for (const std::vector<LowerBound>& more :
       {issue, units, ports,
        std::vector<LowerBound>{{"l1_port", l1_port, "accesses of the busiest L1 over its banks"},
                                {"l1_miss_port", l1_miss_port, "misses and writes of the busiest L1, one per cycle"},
                                {"l2_port", l2_port, "accesses of the busiest L2 slice, one per cycle"},
                                {"dram_bandwidth", dram, "bursts of the busiest DRAM channel on its data bus"}},
        chain_bounds(longest)}) {
    bounds.insert(bounds.end(), more.begin(), more.end());
  }
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
           "ratio", "largest lower bound / gpu.cycles", modules::StatisticKind::share);
}

}  // namespace grtx::sim
