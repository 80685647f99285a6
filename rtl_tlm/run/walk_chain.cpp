// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/walk_chain.h"

#include <algorithm>
#include <array>
#include <bit>

#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/rt_unit/decide/event_effect.h"
#include "grtx/modules/rt_unit/decide/node_visit.h"
#include "grtx/modules/rt_unit/warp_walk/decide/warp_stack.h"

namespace grtx::sim {

using modules::bit;
using modules::kMaxLanes;
using modules::LaneTree;
using modules::WarpStackEntry;
using traces::EventKind;
using traces::LeafOutcome;
using traces::NodeKind;

namespace {

std::uint64_t divide_up(std::uint64_t work, std::uint64_t rate) { return (work + rate - 1) / rate; }

}  // namespace

/// The hits of a call: those of one heap, or of one lane before a shader, are taken one after the other.
class WalkChain::Hits {
 public:
  Hits(const modules::AnyHitUnitConfig& unit, unsigned k, Cycle shader, bool boxes)
      : unit_(unit), k_(k), shader_(shader), boxes_(boxes), ways_(unit.enabled ? unit.count : kMaxLanes) {
    first_.fill(kNever);
  }
  void begin(unsigned lane, unsigned preloaded) { fill_[lane] = preloaded; }
  void found(unsigned lane, const traces::Event& event, Cycle at) {
    if (!modules::EventEffect(event).calls_shader(boxes_)) return;
    first_[lane] = std::min(first_[lane], at);
    cycles_[lane] += cost(lane, event.outcome());
  }
  /// When the last hit of the lane alone is taken.
  Cycle lane_end(unsigned lane) const { return first_[lane] == kNever ? 0 : first_[lane] + cycles_[lane]; }
  /// When the last hit of all is taken.
  Cycle end() const {
    Cycle last = 0;
    for (unsigned way = 0; way < ways_; ++way) {
      Cycle first = kNever, cycles = 0;
      for (unsigned lane = way; lane < kMaxLanes; lane += ways_) {
        first = std::min(first, first_[lane]);
        cycles += cycles_[lane];
      }
      if (first != kNever) last = std::max(last, first + cycles);
    }
    return last;
  }

 private:
  // In whatever order hits come: a lane's heap fills by one with each that is inserted.
  Cycle cost(unsigned lane, LeafOutcome outcome) {
    if (!unit_.enabled) return shader_;
    if (boxes_) return 0;
    if (outcome == LeafOutcome::inserted) return unit_.insertion(fill_[lane] = std::min(fill_[lane] + 1, k_));
    return outcome == LeafOutcome::displaced ? unit_.displacement(k_) : unit_.latency;
  }

  const modules::AnyHitUnitConfig& unit_;
  unsigned k_;
  Cycle shader_;
  bool boxes_;
  unsigned ways_;
  std::array<unsigned, kMaxLanes> fill_{};
  std::array<Cycle, kMaxLanes> first_{};  ///< [lane] its first hit
  std::array<Cycle, kMaxLanes> cycles_{};
};

WalkChain::WalkChain(const modules::RtUnitConfig& config, const traces::Header& header, Cycle fetch, Cycle shader)
    : config_(config),
      traffic_(header, config.memory.traffic),
      fetch_(fetch),
      shader_(shader),
      k_(std::max(header.k, 1U)),
      boxes_(traces::has_box_leaves(header.accel)),
      by_slot_(header.child_order == traces::ChildOrder::slot) {
  // One cycle from the node's arrival to the start of the test.
  const auto stage = [](const modules::IntersectionConfig& unit) {
    return Stage{1 + Cycle{unit.latency}, unit.count, unit.interval};
  };
  box_ = stage(config.ray_box);
  if (boxes_) return;  // a leaf is a box: its node suffices
  leaf_ = stage(config.leaf_unit(header));
  if (modules::transforms_leaves(header)) transform_ = stage(config.ray_transform);
}

WalkChain::NodeTimes WalkChain::node_times(const WarpStackEntry& entry, Cycle start) const {
  const bool internal = entry.kind == NodeKind::internal;
  const auto tests = static_cast<unsigned>(std::popcount(entry.lanes));
  NodeTimes times;
  times.sectors = modules::NodeSectors({entry.kind, traffic_.address(entry.address), false}, traffic_).count();
  const Cycle fetched =
      start + fetch_ + (config_.memory.by_shader ? 0 : divide_up(times.sectors, config_.memory.sectors_per_cycle) - 1);
  const Stage& test = internal ? box_ : leaf_;
  const Cycle transformed = internal ? 0 : transform_.latency;
  times.first_result = fetched + transformed + test.latency;
  times.done = std::max(fetched + transformed + test.last(tests),
                        internal ? 0 : fetched + transform_.last(tests) + test.latency);
  return times;
}

Cycle WalkChain::least_cycles(const UnitLoad& load) const {
  Cycle least = std::max({load.root_done + divide_up(load.under_way, config_.warp_stack.ahead),
                          box_.busy(load.box_tests), leaf_.busy(load.leaf_tests), transform_.busy(load.leaf_tests)});
  if (!config_.memory.by_shader) {
    least = std::max(least, Cycle{divide_up(load.sectors, config_.memory.sectors_per_cycle)});
  }
  return least;
}

WalkCall WalkChain::measure(const traces::RayGroup& group, std::size_t round,
                            std::span<const std::size_t> first_event) const {
  WalkCall call;
  const std::size_t lanes = group.rays.size();
  call.lanes.resize(lanes);
  if (lanes > kMaxLanes) return call;
  std::vector<LaneTree> trees(lanes);
  WarpStackEntry root;
  Hits hits(config_.any_hit_unit, k_, shader_, boxes_);
  for (unsigned lane = 0; lane < lanes; ++lane) {
    const traces::Ray& ray = group.rays[lane];
    if (round >= ray.rounds.size() || ray.rounds[round].event_count == 0) continue;
    const std::span<const traces::Event> events(ray.events.data() + first_event[lane], ray.rounds[round].event_count);
    if (trees[lane].build(events, group, traffic_) != nullptr) return call;
    hits.begin(lane, ray.rounds[round].preloaded);
    root.lanes |= bit(lane);
    root.address = trees[lane].address(0);
    root.kind = trees[lane].kind(0);
  }
  if (root.lanes == 0) return call;

  struct Waiting {
    WarpStackEntry entry;
    Cycle start = 0;
  };
  std::vector<Waiting> waiting{{root, 0}};
  std::vector<WarpStackEntry> children;
  UnitLoad load;
  while (!waiting.empty()) {
    const WarpStackEntry entry = waiting.back().entry;
    const Cycle start = waiting.back().start;
    waiting.pop_back();
    bool visited = false;
    modules::for_each_bit(entry.lanes, [&](unsigned lane) {
      visited = visited || trees[lane].event(entry.event[lane]).kind() != EventKind::cull;
    });
    if (!visited) continue;
    const NodeTimes times = node_times(entry, start);
    call.warp = std::max(call.warp, times.done);
    load.add(times, start, static_cast<unsigned>(std::popcount(entry.lanes)), entry.kind == NodeKind::internal);
    modules::for_each_bit(entry.lanes, [&](unsigned lane) {
      call.lanes[lane] = std::max(call.lanes[lane], times.first_result);
      hits.found(lane, trees[lane].event(entry.event[lane]), times.first_result);
    });
    modules::children_of(
        entry, by_slot_, [&](unsigned lane) -> const LaneTree& { return trees[lane]; }, children);
    for (const WarpStackEntry& child : children) waiting.push_back({child, times.done});
  }
  for (unsigned lane = 0; lane < lanes; ++lane) {
    call.lanes[lane] = std::max(call.lanes[lane], hits.lane_end(lane));
  }
  call.warp = std::max({call.warp, hits.end(), least_cycles(load)});
  return call;
}

}  // namespace grtx::sim
