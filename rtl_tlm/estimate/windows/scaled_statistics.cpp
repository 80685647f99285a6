// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/estimate/windows/scaled_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>

namespace grtx::sim {
namespace {

using nlohmann::ordered_json;

bool of_one_part(std::string_view name) {
  const auto numbered = [name](std::string_view prefix) {
    return name.starts_with(prefix) && name.size() > prefix.size() && name[prefix.size()] >= '0' &&
           name[prefix.size()] <= '9';
  };
  return numbered("gpu.sm") || numbered("gpu.dram.channel") || name.starts_with("gpu.distributor.");
}

bool is_maximum(std::string_view name) {
  return name.ends_with("_max") || name.find(".max_") != name.npos || name.ends_with("deepest_queue");
}

double value_in(const ordered_json& stats, const std::string& name) {
  return stats.contains(name) ? stats.at(name).at("value").get<double>() : 0.0;
}

std::map<std::string, std::uint64_t> exact_counts(const WholeRun& whole) {
  const traces::Totals& t = whole.totals;
  return {{"gpu.rt.node_visits", t.visits()},
          {"gpu.rt.visits_internal", t.visits_internal},
          {"gpu.rt.visits_instance", t.visits_instance},
          {"gpu.rt.visits_leaf", t.visits_leaf},
          {"gpu.rt.culls", t.culls},
          {"gpu.rt.any_hit_calls", t.any_hit_calls},
          {"gpu.simt.any_hit.calls", t.any_hit_calls},
          {"gpu.simt.ray_rounds", t.rounds},
          {"gpu.rt.checkpoint.entries_written", t.checkpoints_written},
          {"gpu.rt.checkpoint.entries_read", t.checkpoints_read},
          {"gpu.simt.evictions", t.evictions},
          {"gpu.simt.processed", t.processed},
          {"gpu.simt.blended", t.blended},
          {"gpu.simt.warps", whole.groups}};
}

}  // namespace

modules::StatisticList whole_statistics(const ordered_json& sample, double factor, const WholeRun& whole,
                                        const GpuConfig& config) {
  modules::StatisticList list;
  const auto cycles = static_cast<std::uint64_t>(std::llround(whole.cycles));
  const std::map<std::string, std::uint64_t> exact = exact_counts(whole);
  const double sms = config.sms;
  std::vector<modules::Statistic> bounds;
  for (const auto& [name, entry] : sample.items()) {
    if (!name.starts_with("gpu.") || of_one_part(name) || name.starts_with("gpu.energy")) continue;
    const std::string unit = entry.at("unit"), description = entry.at("description");
    const bool count = entry.at("value").is_number_integer();
    const double value = entry.at("value").get<double>();
    const auto whole_number = [](double x) { return static_cast<std::uint64_t>(std::llround(x)); };
    if (name == "gpu.cycles") {
      list.add(name, cycles, unit, description + "; estimated");
    } else if (name == "gpu.time_us") {
      list.add(name, whole.cycles / config.core_mhz, unit, description);
    } else if (name.starts_with("gpu.rays.")) {
      continue;  // the shares of primary and secondary rays are not estimated
    } else if (name == "gpu.bound.longest_ray") {
      bounds.push_back({name, whole.longest.ray, unit, description});
    } else if (name == "gpu.bound.longest_warp") {
      bounds.push_back({name, whole.longest.warp, unit, description});
    } else if (name == "gpu.bound.dram_bandwidth" || name == "gpu.bound.l2_port") {
      const bool dram = name == "gpu.bound.dram_bandwidth";
      const double all = factor * value_in(sample, dram ? "gpu.dram.bursts" : "gpu.l2.accesses");
      const double each =
          dram ? config.dram.channel.timing.ccd * config.core_mhz / config.at_bandwidth().memory_mhz : 1.0;
      const bool none = value == 0.0;  // a perfect memory
      const unsigned ports = dram ? config.interleave.dram_channels() : config.interleave.slices;
      bounds.push_back({name, none ? 0 : whole_number(all * each / ports), unit, description});
    } else if (name == "gpu.bound.largest" || name == "gpu.bound.fraction") {
      continue;
    } else if (name.starts_with("gpu.bound.")) {
      bounds.push_back({name, whole_number(factor * value), unit, description});
    } else if (exact.contains(name)) {
      list.add(name, exact.at(name), unit, description);
    } else if (name == "gpu.rt.occupancy") {
      const double entries = sms * whole.cycles;
      list.add(name, factor * value_in(sample, "gpu.rt.occupancy_integral") / entries, unit, description);
    } else if (count) {
      list.add(name, is_maximum(name) ? whole_number(value) : whole_number(factor * value), unit, description);
    } else {
      list.add(name, value, unit, description);
    }
  }
  for (const modules::Statistic& bound : bounds) {
    list.add(bound.name, std::get<std::uint64_t>(bound.value), bound.unit, bound.description);
  }
  const auto largest = std::max_element(bounds.begin(), bounds.end(), [](const auto& a, const auto& b) {
    return std::get<std::uint64_t>(a.value) < std::get<std::uint64_t>(b.value);
  });
  const std::uint64_t most = largest == bounds.end() ? 0 : std::get<std::uint64_t>(largest->value);
  const std::string which =
      largest == bounds.end() ? "none" : largest->name.substr(std::string_view("gpu.bound.").size());
  list.add("gpu.bound.largest", most, "cycles", "largest lower bound, estimated: " + which);
  list.add("gpu.bound.fraction", static_cast<double>(most) / std::max(1.0, whole.cycles), "ratio",
           "largest lower bound / gpu.cycles");
  return list;
}

}  // namespace grtx::sim
