// SPDX-License-Identifier: Apache-2.0
// Policies of somebody's own by their keys: warp, cache line, SM, DRAM command.
//   own_policies TRACE.grtx
#include <bit>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/modules/cache/decide/replacement.h"
#include "grtx/modules/dram/decide/dram_scheduling.h"
#include "grtx/modules/rt_unit/scheduler/decide/warp_selection.h"
#include "grtx/modules/simt/decide/work_distribution.h"
#include "grtx/rtl_tlm/run/simulation.h"

namespace {

using grtx::LaneMask;
using namespace grtx::modules;

std::uint64_t selections, lines, launches;
bool told = true;

struct MostLanes final : WarpSelection {
  unsigned select(LaneMask candidates, const std::vector<std::uint64_t>& ages, const SelectableWarps& warps) override {
    auto best = static_cast<unsigned>(std::countr_zero(candidates));
    for (unsigned entry = 0; entry < ages.size(); ++entry) {
      if ((candidates >> entry & 1) != 0 && warps.at(entry).active() > warps.at(best).active()) best = entry;
    }
    const SelectableWarp warp = warps.at(best);
    told = told && warp.active() > 0 && warp.active() <= warp.unfinished && warp.next(NextStep::leaf) <= warp.active();
    ++selections;
    return best;
  }
};

/// The line that was filled first, but no line of nodes where another is.
struct NodesLast final : CacheReplacement {
  NodesLast(std::uint64_t sets, unsigned all) : ways(all), nodes(sets * all), next(sets) {}
  void filled(std::uint64_t set, unsigned way, const MemoryRequest& access) override {
    nodes[set * ways + way] = is_node(access.region);
    next[set] = (way + 1) % ways;
    ++lines;
  }
  void referenced(std::uint64_t, unsigned, const MemoryRequest& access) override {
    told = told && access.address % kSectorBytes == 0 && access.sm < 2;
  }
  unsigned victim(std::uint64_t set, const MemoryRequest&) const override {
    for (unsigned i = 0; i < ways; ++i) {
      const unsigned way = (next[set] + i) % ways;
      if (!nodes[set * ways + way]) return way;
    }
    return next[set];
  }
  unsigned bits_per_line() const override { return 2; }
  unsigned ways;
  std::vector<bool> nodes;
  std::vector<unsigned> next;
};

struct EmptiestSm final : WorkDistribution {
  unsigned choose(const grtx::traces::RayGroup& group, const std::vector<unsigned>& room) override {
    unsigned best = 0;
    for (unsigned sm = 1; sm < room.size(); ++sm) best = room[sm] > room[best] ? sm : best;
    told = told && !group.rays.empty();
    ++launches;
    return room[best] != 0 ? best : kNobody;
  }
};

int run(int argc, char** argv) {
  if (argc != 2) throw grtx::Error("own_policies", "arguments", "TRACE.grtx");
  register_warp_selection("most_lanes", [] { return std::make_unique<MostLanes>(); });
  register_cache_replacement("nodes_last",
                             [](std::uint64_t sets, unsigned ways) { return std::make_unique<NodesLast>(sets, ways); });
  register_work_distribution("emptiest_sm", [](unsigned) { return std::make_unique<EmptiestSm>(); });
  const auto config = grtx::sim::load_config(
      "", {"gpu.sms=2", "rt.scheduler.policy=most_lanes", "l1.replacement=nodes_last", "l2.replacement=nodes_last",
           "gpu.distribution=emptiest_sm", "dram.scheduling=" + dram_scheduling_names().front()});
  const auto result = grtx::sim::simulate(argv[1], config, {});
  for (const std::string& violation : result.violations) std::printf("%s\n", violation.c_str());
  std::printf("%llu cycles\n", static_cast<unsigned long long>(result.cycles));
  return result.violations.empty() && told && selections > 0 && lines > 0 && launches > 0 ? 0 : 1;
}

}  // namespace

int sc_main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
