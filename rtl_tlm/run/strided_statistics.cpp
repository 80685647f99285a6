// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/strided_statistics.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

namespace grtx::sim {
namespace {

/// Not to be scaled: counted by every event, timed or not, or a state at the end of the run.
bool is_exact(std::string_view name) {
  constexpr std::array<std::string_view, 19> kBegin = {"gpu.rt.visits_",
                                                       "gpu.rt.node_visits",
                                                       "gpu.rt.culls",
                                                       "gpu.rt.replay_",
                                                       "gpu.rt.any_hit_calls",
                                                       "gpu.rt.intersection_calls",
                                                       "gpu.rt.calls",
                                                       "gpu.rt.checkpoint.entries_",
                                                       "gpu.simt.warps",
                                                       "gpu.simt.rounds",
                                                       "gpu.simt.ray_rounds",
                                                       "gpu.simt.any_hit.calls",
                                                       "gpu.simt.intersection.calls",
                                                       "gpu.simt.eviction",
                                                       "gpu.simt.processed",
                                                       "gpu.simt.blended",
                                                       "gpu.distributor.groups",
                                                       "gpu.distributor.most_on_one_sm",
                                                       "gpu.distributor.fewest_on_one_sm"};
  const auto begins = [name](std::string_view prefix) { return name.starts_with(prefix); };
  return std::any_of(kBegin.begin(), kBegin.end(), begins) || name == "gpu.l2.dirty_at_end" ||
         (name.starts_with("gpu.simt.lsu.") && name.ends_with("_instructions")) ||
         (name.starts_with("gpu.sm") && name.ends_with(".warps"));
}

bool is_largest(std::string_view name) {
  return name.ends_with("_max") || name.find(".max_") != name.npos || name.ends_with("deepest_queue");
}

/// Times from the acceptance of a traceRay call to its end, and of the whole run.
bool spans_events(std::string_view name) {
  return name == "gpu.rt.warp_latency" || name == "gpu.rt.warp_latency_max" || name == "gpu.time_us";
}

}  // namespace

modules::StatisticList of_all_events(const modules::StatisticList& list, unsigned stride) {
  modules::StatisticList all;
  for (modules::Statistic s : list.items()) {
    if (s.name == "gpu.simt.any_hit.batches") continue;  // calls in zero time are batches of one lane
    if (auto* count = std::get_if<std::uint64_t>(&s.value)) {
      if (!is_exact(s.name) && (!is_largest(s.name) || spans_events(s.name))) *count *= stride;
    } else if (spans_events(s.name)) {
      std::get<double>(s.value) *= stride;
    } else if (s.name == "gpu.rt.merge_factor") {  // counted: all visits / timed fetches
      std::get<double>(s.value) /= stride;
    }
    all.add(std::move(s));
  }
  return all;
}

std::vector<LowerBound> of_all_events(std::vector<LowerBound> bounds, unsigned stride) {
  for (LowerBound& bound : bounds) {
    if (!bound.name.starts_with("longest_")) bound.cycles *= stride;
  }
  return bounds;
}

}  // namespace grtx::sim
