// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/estimate/windows/group_work.h"

#include <algorithm>
#include <bit>

namespace grtx::sim {
namespace {

/// Mean sectors moved to write or read a checkpoint entry. Of eight consecutive 20 B entries four straddle two sectors;
/// entries whose size divides a sector never do. joined: consecutive entries are combined, so that a sector moves once.
float checkpoint_sectors(const modules::CheckpointConfig& config, bool joined) {
  if (joined) return static_cast<float>(config.entry_bytes) / static_cast<float>(modules::kSectorBytes);
  return modules::kSectorBytes % config.entry_bytes == 0 ? 1.0F : 1.5F;
}

std::uint64_t nodes_per_warp(std::uint64_t bytes, unsigned warps) {
  return static_cast<std::uint64_t>(kUsefulCacheShare * static_cast<double>(bytes) /
                                    static_cast<double>(warps * traces::kNodeUnit));
}

}  // namespace

WorkCounter::Tags::Tags(std::uint64_t nodes) : sets_(std::bit_floor(std::max<std::uint64_t>(1, nodes / kWays))) {
  entries_.resize(sets_ * kWays);
}

bool WorkCounter::Tags::access(std::uint32_t unit) {
  std::uint32_t* const set = &entries_[(((unit * 0x9E3779B1u) >> 8) & (sets_ - 1)) * kWays];
  std::size_t way = 0;
  while (way < kWays - 1 && set[way] != unit + 1) ++way;
  const bool hit = set[way] == unit + 1;
  for (; way > 0; --way) set[way] = set[way - 1];
  set[0] = unit + 1;
  return hit;
}

BufferTraffic::BufferTraffic(const traces::Header& header, const GpuConfig& config) {
  const std::uint64_t sectors =
      (header.gaussian_record_bytes + header.sh_record_bytes + modules::kSectorBytes - 1) / modules::kSectorBytes;
  processed = static_cast<float>(sectors);
  if (!header.checkpoint) return;
  written = checkpoint_sectors(config.rt.checkpoint, config.rt.checkpoint.write_combine);
  read = checkpoint_sectors(config.rt.checkpoint, config.rt.checkpoint.read_buffer);
}

WorkCounter::WorkCounter(const traces::Header& header, const GpuConfig& config)
    : header_(header),
      traffic_(header, config),
      prefetch_(config.rt.sibling_prefetch),
      l1_(nodes_per_warp(config.l1.geometry.bytes, config.rt.warp_buffer.entries * config.rt_units)),
      l2_(nodes_per_warp(config.l2_bytes, config.sms * config.rt.warp_buffer.entries * config.rt_units)) {}

void WorkCounter::step(Lane& lane, const traces::RayGroup& group) {
  const traces::Event& event = *lane.event++;
  --lane.left;
  const traces::EventKind kind = event.kind();
  lane.work.dram_sectors += traffic_.written * static_cast<float>(std::popcount(event.written()));
  if (kind == traces::EventKind::replay_take || kind == traces::EventKind::replay_forward) {
    lane.work.dram_sectors += traffic_.read;
  }
  if (kind > traces::EventKind::visit_leaf) return;
  const bool internal = kind == traces::EventKind::visit_internal;
  const std::uint32_t unit = internal ? group.nodes[event.node].address : event.node;
  const float sectors = kind == traces::EventKind::visit_instance ? 4.0F : 2.0F;
  const bool l2_hit = l2_.access(unit);
  const bool l1_hit = l1_.access(unit);
  lane.work.sectors += sectors;
  if (!l1_hit && !l2_hit) lane.work.dram_sectors += sectors;
  // A leaf after another leaf: its sibling, which has been prefetched.
  const bool low_latency = l1_hit || (prefetch_ && !internal && lane.after_leaf);
  lane.work.steps += low_latency ? kL1HitStep : 1.0F;
  if (!internal || !l1_hit) lane.after_leaf = !internal;
  const bool shader = traces::has_box_leaves(header_.accel) || traces::calls_any_hit(event.outcome());
  if (kind == traces::EventKind::visit_leaf && shader) lane.work.steps += kAnyHitStep;
}

GroupWork WorkCounter::count(const traces::RayGroup& group) {
  GroupWork work;
  l1_.clear();
  l2_.clear();
  std::size_t rounds = 0;
  for (const traces::Ray& ray : group.rays) rounds = std::max(rounds, ray.rounds.size());
  std::vector<const traces::Event*> next;
  std::vector<LaneWork> done;
  for (const traces::Ray& ray : group.rays) next.push_back(ray.events.data());
  for (std::size_t r = 0; r < rounds; ++r) {
    lanes_.clear();
    for (std::size_t i = 0; i < group.rays.size(); ++i) {
      if (r >= group.rays[i].rounds.size()) continue;
      const traces::Round& round = group.rays[i].rounds[r];
      Lane lane;
      lane.event = next[i];
      lane.left = round.event_count;
      lane.work.dram_sectors = traffic_.processed * static_cast<float>(round.processed_count);
      next[i] += round.event_count;
      if (lane.left > 0) lanes_.push_back(lane);
    }
    for (std::size_t unfinished = lanes_.size(); unfinished > 0;) {
      for (Lane& lane : lanes_) {
        if (lane.left == 0) continue;
        step(lane, group);
        if (lane.left == 0) --unfinished;
      }
    }
    done.clear();
    for (const Lane& lane : lanes_) {
      if (lane.work.steps > 0.0F) done.push_back(lane.work);
    }
    std::sort(done.begin(), done.end(), [](const LaneWork& a, const LaneWork& b) { return a.steps < b.steps; });
    for (const LaneWork& lane : done) {
      work.sectors += static_cast<double>(lane.sectors);
      work.dram_sectors += static_cast<double>(lane.dram_sectors);
    }
    if (!done.empty()) work.steps += static_cast<double>(done.back().steps);
  }
  return work;
}

}  // namespace grtx::sim
