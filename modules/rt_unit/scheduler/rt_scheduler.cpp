// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/scheduler/rt_scheduler.h"

#include <algorithm>
#include <bit>
#include <ostream>
#include <string>

#include "grtx/modules/kernel/wrong_answer.h"

namespace grtx::modules {

using traces::Event;
using traces::EventKind;

const CounterTable<RtSchedulerCounters>& RtSchedulerCounters::table() {
  using C = RtSchedulerCounters;
  using W = WarpWalkCounters;
  const auto of_walk = [](auto field) {
    return [field](auto& c) -> auto& { return c.walk.*field; };
  };
  static const CounterTable<C> table =
      CounterTable<C>()
          .sum(&C::selections, "selections", "cycles", "cycles in which a warp was scheduled")
          .sum(&C::lanes_handled, "lanes_handled", "lanes", "lanes handled when their warp was scheduled")
          .sum(&C::lanes_active, "lanes_active", "lanes", "unfinished lanes of scheduled warps")
          .share({"lanes_handled", &C::lanes_handled}, {"lanes_active", &C::lanes_active}, "simt_efficiency", "ratio",
                 "lanes handled / unfinished lanes of scheduled warps")
          .by_name<Stall>(&C::stall, "stall", "cycles", "cycles without a scheduled warp, reason: {}")
          .exact(&C::visits_internal, "visits_internal", "events", "internal nodes visited by lanes")
          .exact(&C::visits_instance, "visits_instance", "events", "instance leaves visited by lanes")
          .exact(&C::visits_leaf, "visits_leaf", "events", "primitive leaves visited by lanes")
          .exact(&C::culls, "culls", "events", "stack entries found beyond t_max")
          .sum(&C::replay_takes, "replay_takes", "events", "source entries traversed")
          .sum(&C::replay_forwards, "replay_forwards", "events", "source entries beyond t_max")
          .exact(&C::any_hit_calls, "any_hit_calls", "calls", "any-hit shader calls of lanes")
          .when([](const C& c) { return c.intersection_calls != 0; })
          .sum(&C::intersection_calls, "intersection_calls", "calls", "intersection shader calls of lanes")
          .when([](const C& c) { return c.walk.entries != 0; })
          .sum(of_walk(&W::entries), "walk.entries", "entries", "stack entries of warps that were taken")
          .mean({"lanes_handled", &C::lanes_handled}, {"walk.entries", of_walk(&W::entries)}, "walk.lanes_per_entry",
                "lanes", "mean lanes of a stack entry of a warp")
          .sum(of_walk(&W::dropped), "walk.dropped", "entries", "of these, entries beyond t_max of all their lanes")
          .sum(of_walk(&W::in_vain), "walk.in_vain", "tests", "tests of lanes for which a node is beyond t_max")
          .sum(of_walk(&W::under_way))
          .mean({"", of_walk(&W::under_way)}, {"", [](const C& c) { return c.walk.entries - c.walk.dropped; }},
                "walk.under_way", "entries", "mean entries of a warp under way when one starts")
          .largest(of_walk(&W::most_waiting), "walk.max_waiting", "entries", "deepest stack of a warp");
  return table;
}

RtScheduler::RtScheduler(const sc_core::sc_module_name& name, const Config& config, unsigned entries, bool boxes)
    : SchedulerBase(name, config, entries, boxes) {}

void RtScheduler::end_of_elaboration() {
  SchedulerBase::end_of_elaboration();
  if (prefetch.size() > 0) prefetcher_ = prefetch.operator->();
}

void RtScheduler::begin(unsigned entry) {
  const Warp& warp = buffer_->warp(entry);
  for_each_bit(warp.lanes, [&](unsigned i) {
    const LaneId id = lane_id(entry, i);
    const bool replays = (warp.replaying & bit(i)) != 0;
    if (checkpoint_ != nullptr) {
      // A replay round reads every source entry.
      std::uint32_t entries = 0;
      if (replays && checkpoint_->needs_source_entries()) {
        entries = source_entries({warp.lane[i].next, warp.lane[i].left});
      }
      checkpoint_->begin_lane(id, warp.slot, warp.round, replays, entries, warp.group->rays[i]);
    }
    if (prefetcher_ != nullptr) prefetcher_->begin_lane(id, warp.slot, replays);
    if (stack_ != nullptr) stack_->begin_lane(id, warp.slot);
    any_hit_->begin_lane(id, warp.group->rays[i].rounds[warp.round].preloaded);
  });
}

void RtScheduler::schedule(Cycle now) {
  const LaneMask candidates = buffer_->ready_entries();
  if (candidates == 0 || !memory_->has_room()) {
    count_idle(1);
    return;
  }
  const unsigned entry = selected_entry(*selection_, config_.policy, candidates, buffer_->ages(), *this);
  const Warp& warp = buffer_->warp(entry);
  const LaneMask lanes = warp.in_state(LaneState::ready);
  ++counters_.selections;
  counters_.lanes_handled += static_cast<unsigned>(std::popcount(lanes));
  counters_.lanes_active += static_cast<unsigned>(std::popcount(warp.active()));
  memory_->begin_warp(now, entry);
  if (prefetcher_ != nullptr) prefetcher_->begin_warp();
  LaneMask fetching = 0;
  for_each_bit(lanes, [&](unsigned i) {
    const LaneId id = lane_id(entry, i);
    const Event event = warp.lane[i].event;
    switch (event.kind()) {
      case EventKind::visit_internal:
      case EventKind::visit_instance:
      case EventKind::visit_leaf:
        visit(id, warp, event);
        fetching |= bit(i);
        break;
      case EventKind::cull:
        ++counters_.culls;
        move_stack(id);
        complete(id, EventEffect(event).checkpoints(), LaneState::ready);
        break;
      case EventKind::replay_take:
      case EventKind::replay_forward:
        if (checkpoint_ == nullptr) refuse(id, kRuleReplayNeedsCheckpoints);
        if (checkpoint_->read(id)) {
          replay(id, LaneState::ready);
        } else {
          buffer_->move(entry, bit(i), LaneState::ready, LaneState::waiting_checkpoint_read);
        }
        break;
      default:
        refuse(id, "has an event of unknown kind");
    }
  });
  if (fetching != 0) buffer_->move(entry, fetching, LaneState::ready, LaneState::waiting_memory);
}

SelectableWarp RtScheduler::at(unsigned entry) const {
  const Warp& warp = buffer_->warp(entry);
  SelectableWarp seen;
  seen.unfinished = static_cast<unsigned>(std::popcount(warp.active()));
  for_each_bit(warp.in_state(LaneState::ready), [&](unsigned i) {
    const EventKind kind = warp.lane[i].event.kind();
    const NextStep step = kind == EventKind::visit_internal   ? NextStep::internal
                          : kind == EventKind::visit_instance ? NextStep::instance
                          : kind == EventKind::visit_leaf     ? NextStep::leaf
                                                              : NextStep::other;
    ++seen.lanes[static_cast<std::size_t>(step)];
    seen.stack_depth = std::max(seen.stack_depth, warp.lane[i].stack_depth);
  });
  return seen;
}

void RtScheduler::count_visit(const Event& event) {
  switch (event.kind()) {
    case EventKind::visit_internal:
      ++counters_.visits_internal;
      break;
    case EventKind::visit_instance:
      ++counters_.visits_instance;
      break;
    default:
      ++counters_.visits_leaf;
  }
}

void RtScheduler::count_shader_call(const EventEffect& effect) {
  counters_.any_hit_calls += effect.calls_any_hit() ? 1 : 0;
  counters_.intersection_calls += boxes_ ? 1 : 0;
}

NodeVisit RtScheduler::node_of(LaneId id, const Event& event) const {
  const std::optional<NodeVisit> node = node_visit(event, *buffer_->warp(entry_of(id)).group, *traffic_);
  if (!node) refuse(id, rule_of_missing_node(event));
  return *node;
}

void RtScheduler::visit(LaneId id, const Warp& warp, const Event& event) {
  count_visit(event);
  const NodeVisit node = node_of(id, event);
  memory_->visit(id, node.kind, node.address, node.header);
  if (event.kind() == EventKind::visit_internal || prefetcher_ == nullptr) return;
  prefetcher_->note_leaf(id, *warp.group, event.node);
}

void RtScheduler::move_stack(LaneId id) {
  Lane& lane = buffer_->lane(id);
  const EventEffect effect(lane.event);
  if (!effect.move_stack(lane.stack_depth)) refuse(id, kRuleNodeOnStack);
  if (effect.pushed() != 0) buffer_->note_stack_depth(lane.stack_depth);
}

void RtScheduler::unit_result(Cycle now, LaneId id) {
  if (!buffer_->in_unit(id))
    throw WrongAnswer("has a result for lane " + std::to_string(id) + ", which asked for none");
  const Event event = buffer_->lane(id).event;
  const EventEffect effect(event);
  move_stack(id);
  if (event.kind() == EventKind::visit_internal) note_event(id, event);
  if (effect.calls_shader(boxes_)) {
    count_shader_call(effect);
    any_hit_->arrive(now, id);
  } else {
    complete(id, effect.checkpoints(), LaneState::in_unit);
  }
}

void RtScheduler::replay(LaneId id, LaneState from) {
  const Event event = buffer_->lane(id).event;
  if (event.kind() == EventKind::replay_take) note_event(id, event);
  ++(event.kind() == EventKind::replay_take ? counters_.replay_takes : counters_.replay_forwards);
  move_stack(id);
  complete(id, EventEffect(event).checkpoints(), from);
}

void RtScheduler::entry_read(LaneId id) { replay(id, LaneState::waiting_checkpoint_read); }

void RtScheduler::complete(LaneId id, unsigned checkpoints, LaneState from) {
  Lane& lane = buffer_->lane(id);
  const bool last = !lane.advance();
  if (!last && lane.event.kind() == EventKind::visit_internal) {
    const auto& nodes = buffer_->warp(entry_of(id)).group->nodes;
    if (lane.event.node < nodes.size()) prefetch_for_read(&nodes[lane.event.node]);
  }
  if (stack_ != nullptr && stack_->settle(id, lane.stack_depth, !last && EventEffect(lane.event).takes_top())) {
    buffer_->warp(entry_of(id)).checkpoints[lane_of(id)] = static_cast<std::uint8_t>(checkpoints);
    buffer_->move(entry_of(id), bit(lane_of(id)), from, LaneState::waiting_stack);
    return;
  }
  hand_over(id, checkpoints, from);
}

void RtScheduler::stack_settled(LaneId id) {
  const Warp& warp = buffer_->warp(entry_of(id));
  hand_over(id, warp.checkpoints[lane_of(id)], LaneState::waiting_stack);
}

void RtScheduler::hand_over(LaneId id, unsigned checkpoints, LaneState from) {
  const Lane& lane = buffer_->lane(id);
  const bool last = lane.left == 0;
  LaneState to = last ? end_state(id) : LaneState::ready;
  if (checkpoint_ != nullptr) {
    if (checkpoint_->submit(id, checkpoints, last)) to = LaneState::waiting_checkpoint_write;
  } else if (checkpoints != 0) {
    refuse(id, kRuleEntriesNeedCheckpoints);
  }
  if (to != from) buffer_->move(entry_of(id), bit(lane_of(id)), from, to);
}

void RtScheduler::entries_taken(LaneId id) {
  const Lane& lane = buffer_->lane(id);
  const LaneState to = lane.left == 0 ? LaneState::finished : LaneState::ready;
  buffer_->move(entry_of(id), bit(lane_of(id)), LaneState::waiting_checkpoint_write, to);
}

void RtScheduler::any_hit_done(Cycle /*now*/, const AnyHitDone& done) {
  const unsigned entry = entry_of_answer(done);
  for_each_bit(done.lanes, [&](unsigned i) {
    const LaneId id = lane_id(entry, i);
    complete(id, EventEffect(buffer_->lane(id).event).checkpoints(), LaneState::in_any_hit);
  });
  if (buffer_->warp(entry).in_state(LaneState::in_any_hit) == 0) any_hit_->finished(entry);
}

void RtScheduler::note_event(LaneId id, const Event& event) {
  if (prefetcher_ == nullptr) return;
  if (event.kind() == EventKind::visit_internal) {
    prefetcher_->note_internal(id, *buffer_->warp(entry_of(id)).group, event.node, event.pushed(), event.checkpoints);
  } else if (event.kind() == EventKind::replay_take) {
    prefetcher_->note_replayed(id, event.node);
  }
}

void RtScheduler::dump_state(std::ostream& out) const {
  out << name() << ": " << counters_.selections << " warps selected\n";
}

Inventory RtScheduler::inventory() const {
  Inventory inventory{name(), {}, {}};
  const std::uint64_t n = entries_;
  inventory.storage.push_back({"age_matrix", StorageKind::flip_flop, n * n});
  inventory.operators.push_back({"arbiter", static_cast<unsigned>(n), n});
  // t-value validation of the nearest stack entry against t_min and t_max, for each lane of the scheduled warp.
  inventory.operators.push_back({"fp_compare", 32, 2ull * kMaxLanes});
  return inventory;
}

PartInfo part_info(const RtSchedulerConfig&) {
  PartInfo part;
  part.name = "rt_scheduler";
  part.title = "RT scheduler and warp buffer";
  part.statistics = {"gpu.rt."};
  part.keys = {"rt."};
  part.bounds = {{.name = "issue",
                  .statistics = {"gpu.rt.selections"},
                  .limit = PartBound::Limit::issue,
                  .description = "cycles in which the busiest RT unit scheduled a warp",
                  .words = "the issue of the RT units, a warp a cycle"}};
  return part;
}

}  // namespace grtx::modules
