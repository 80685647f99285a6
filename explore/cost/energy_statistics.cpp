// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/cost/energy_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <variant>

#include "grtx/explore/cost/run_energy.h"

namespace grtx::explore {
namespace {

struct Group {
  const char* name;
  const char* description;
};
constexpr Group kGroups[] = {{"rt",
                              "energy of the RT units: node, triangle, sphere, Gaussian and transform tests, "
                              "warp buffer, any-hit and checkpoint unit"},
                             {"simt", "energy of the SIMT cores: arithmetic and registers of shader instructions"},
                             {"l1", "energy of the L1 caches' data arrays"},
                             {"crossbar", "energy of the packets between SMs and L2"},
                             {"l2", "energy of the L2 slices' data arrays"},
                             {"dram", "energy of the bytes to and from DRAM"},
                             {"own", "energy of units that are not the project's, as they price what they count"},
                             {"leakage", "leakage of the whole modelled machine over gpu.time_us"}};

std::uint64_t picojoules(double nanojoules) { return static_cast<std::uint64_t>(std::llround(nanojoules * 1e3)); }

double nanojoules(std::uint64_t pj) { return static_cast<double>(pj) / 1e3; }

}  // namespace

void describe_energy(const sim::GpuConfig& config, const std::vector<modules::Inventory>& inventories,
                     std::uint64_t rays, modules::StatisticList& list) {
  std::unordered_map<std::string, double> counts;
  for (const modules::Statistic& s : list.items()) {
    counts[s.name] = std::visit([](auto value) { return static_cast<double>(value); }, s.value);
  }
  const auto value = [&](const std::string& name) {
    const auto found = counts.find(name);
    return found == counts.end() ? std::nullopt : std::optional(found->second);
  };
  const CostOptions options;
  std::vector<EnergyPart> parts = run_energy(value, config, inventories, options, {});

  for (const modules::Statistic& s : list.items()) {
    if (s.picojoules == 0.0) continue;
    const double actions = std::visit([](auto counted) { return static_cast<double>(counted); }, s.value);
    parts.push_back({"own." + s.name, actions, Range::exactly(s.picojoules * actions * 1e-3), s.unit});
  }
  std::uint64_t low = 0, central = 0, high = 0;
  std::unordered_map<std::string, std::uint64_t> by_group;
  for (const EnergyPart& part : parts) {
    low += picojoules(part.nanojoules.low);
    central += picojoules(part.nanojoules.central);
    high += picojoules(part.nanojoules.high);
    by_group[part.name.substr(0, part.name.find('.'))] += picojoules(part.nanojoules.central);
  }
  const std::string node = fmt::format("at {} nm", options.nm);
  const auto add = [&list](const std::string& name, std::uint64_t pj, const std::string& description) {
    list.add(name, nanojoules(pj), "nJ", description, modules::StatisticKind::count);
  };
  add("gpu.energy_nj", central, "energy of the run " + node + ", DRAM and leakage included");
  add("gpu.energy_nj_low", low, "the same with every price at the low end of its band");
  add("gpu.energy_nj_high", high, "the same with every price at the high end of its band");
  list.add("gpu.energy_nj_per_ray", nanojoules(central) / static_cast<double>(std::max<std::uint64_t>(1, rays)), "nJ",
           "gpu.energy_nj over the rays of the trace", modules::StatisticKind::ratio);
  for (const Group& group : kGroups) {
    const std::string_view name = group.name;
    if (name == "own" && !by_group.contains(group.name)) continue;
    add(std::string("gpu.energy_nj.") + group.name, by_group[group.name], group.description);
  }
}

}  // namespace grtx::explore
