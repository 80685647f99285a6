#include "grtx/rtl_tlm/estimate/model/model_work.h"

#include <algorithm>
#include <cmath>

namespace grtx::sim {
namespace {

GroupWork work_of(const GroupCounts& counts, double l1_nodes, double l2_nodes, const TrafficOfEntries& traffic) {
  GroupWork work;
  work.kind = counts.kind;
  work.rounds.reserve(counts.rounds.size());
  for (const RoundCounts& round : counts.rounds) {
    work.processed += round.processed;
    RoundWork& out = work.rounds.emplace_back();
    std::uint64_t visits = 0;
    for (const LaneCounts& lane : round.lanes) visits += lane.visits;
    if (visits == 0) continue;
    const double near = hits_within(round, l1_nodes);
    const double sectors = static_cast<double>(round.units) / static_cast<double>(visits);
    const double entries = static_cast<double>(round.written) * static_cast<double>(traffic.written) +
                           static_cast<double>(round.read) * static_cast<double>(traffic.read) +
                           static_cast<double>(round.processed) * static_cast<double>(traffic.processed);
    const double far =
        sectors * (1.0 - std::max(near, hits_within(round, l2_nodes))) + entries / static_cast<double>(visits);
    const double step = near * static_cast<double>(kNearStep) + (1.0 - near);
    for (const LaneCounts& lane : round.lanes) {
      const double n = lane.visits;
      out.lanes.push_back({static_cast<float>(n * step + lane.any_hits * static_cast<double>(kAnyHitStep)),
                           static_cast<float>(n * sectors), static_cast<float>(n * far)});
    }
    std::sort(out.lanes.begin(), out.lanes.end(),
              [](const LaneWork& a, const LaneWork& b) { return a.steps < b.steps; });
    work.sectors += static_cast<double>(visits) * sectors;
    work.far += static_cast<double>(visits) * far;
    work.steps += static_cast<double>(out.lanes.back().steps);
  }
  return work;
}

}  // namespace

double hits_within(const RoundCounts& round, double nodes) {
  double all = 0.0, hits = 0.0;
  for (std::size_t c = 0; c < kReuseClasses; ++c) {
    const double visits = round.reuse[c];
    all += visits;
    if (c + 1 == kReuseClasses) continue;
    const double from = c == 0 ? 0.0 : std::exp2(static_cast<double>(c) - 1.0);
    // Distances from .. 2 from - 1 are hits in caches of one node more.
    const double share = c == 0 ? std::min(nodes, 1.0) : nodes <= from ? 0.0 : std::min(1.0, std::log2(nodes / from));
    hits += visits * share;
  }
  return all == 0.0 ? 0.0 : hits / all;
}

std::vector<GroupWork> work_of(const TraceCounts& counts, const traces::Header& header, const GpuConfig& config) {
  const double calls = config.rt.warp_buffer.entries * config.rt_units;
  const auto nodes = [](std::uint64_t bytes, double warps) {
    return kUsefulShare * static_cast<double>(bytes) / (warps * traces::kNodeUnit);
  };
  const double l1_nodes = nodes(config.l1.geometry.bytes, calls);
  const double l2_nodes = nodes(config.l2_bytes, calls * config.sms);
  const TrafficOfEntries traffic(header, config);
  std::vector<GroupWork> work;
  work.reserve(counts.groups.size());
  for (const GroupCounts& group : counts.groups) work.push_back(work_of(group, l1_nodes, l2_nodes, traffic));
  return work;
}

}  // namespace grtx::sim
