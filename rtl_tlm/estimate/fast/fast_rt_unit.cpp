#include "grtx/rtl_tlm/estimate/fast/fast_rt_unit.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <utility>

#include "grtx/base/error.h"
#include "grtx/modules/rt_unit/decide/policies/oldest_first.h"
#include "grtx/rtl_tlm/estimate/fast/fast_simt.h"
#include "grtx/rtl_tlm/estimate/fast/lowest_bits.h"

namespace grtx::sim::fast {

using namespace modules;
using traces::Event;
using traces::EventKind;
using traces::NodeKind;

RtUnit::RtUnit(Shared& shared, unsigned sm, L1& l1, Simt& simt)
    : shared_(shared),
      config_(shared.config.rt),
      sm_(sm),
      l1_(l1),
      simt_(simt),
      checkpoints_(shared, sm, l1),
      lanes_(std::size_t{config_.warp_buffer.entries} * kMaxLanes),
      calls_(config_.warp_buffer.entries),
      ages_(config_.warp_buffer.entries),
      cursors_(shared.config.resident()),
      free_entries_(lowest_bits(config_.warp_buffer.entries)),
      box_(config_.ray_box),
      leaf_(shared.traffic.leaf_kind() == NodeKind::triangle ? config_.ray_triangle
                                                             : config_.sphere_unit(shared.header)),
      transform_(config_.ray_transform),
      transforms_leaves_(config_.transforms_leaves(shared.header)),
      boxes_(traces::has_box_leaves(shared.header.accel)),
      spreads_(shared.stride > 1 && shared.config.fast.spread) {
  counters_.units = 1;
  if (config_.has_prefetcher(shared.header)) prefetcher_.emplace(shared, l1);
  if (config_.warp_buffer.spill) stacks_.emplace(shared, sm, l1);
}

void RtUnit::refuse(LaneId id, const char* rule) const {
  const Call& call = calls_[entry_of(id)];
  throw Error("trace", fmt::format("group {} lane {} round {}", call.group->index, lane_of(id), call.round), rule);
}

void RtUnit::call(Cycle now, const TraceCall& call) {
  waiting_calls_.push(call);
  accept(now);
}

void RtUnit::accept(Cycle now) {
  while (free_entries_ != 0 && !waiting_calls_.empty()) {
    const TraceCall message = waiting_calls_.front();
    waiting_calls_.pop();
    const auto entry = static_cast<unsigned>(std::countr_zero(free_entries_));
    Call& call = calls_[entry];
    call.fetches.clear(now);
    begin(call, entry, message);
    call.accepted = call.since = call.selected = now;
    call.wait = call.ready != 0 ? WarpWait::ready : WarpWait::retire;
    count_stall(shared_.agenda.now());
    free_entries_ &= ~bit(entry);
    if (occupied_ == 0) oldest_ = entry;
    occupied_ |= bit(entry);
    ages_[entry] = next_age_++;
    ++counters_.warp_buffer.calls;
    if (call.ready != 0) {
      ready_ |= bit(entry);
      select_soon(now);
    } else {
      retire(now, entry);
    }
  }
}

void RtUnit::begin(Call& call, unsigned entry, const TraceCall& message) {
  RoundCursor& cursor = cursors_[message.slot];
  cursor.seek(*message.group, message.round);
  call.group = message.group;
  call.round = message.round;
  call.slot = message.slot;
  call.active = call.ready = call.waiting_any_hit = call.in_any_hit = call.checkpointing = call.stacking = 0;
  const auto before = static_cast<unsigned>(shared_.draw() % shared_.stride);  // events of each lane, without time
  for_each_bit(message.lanes, [&](unsigned i) {
    const auto events = cursor.events(i);
    if (events.empty()) return;
    const bool replay = cursor.round(i).replay;
    const LaneId id = lane_id(entry, i);
    Lane& lane = lanes_[id];
    lane.next = events.data();
    lane.end = events.data() + events.size();
    lane.depth = replay ? 0 : 1;  // a round that does not replay starts with the root on the stack
    lane.shaded = lane.stacking = lane.settling = false;
    lane.begins = true;
    lane.owed = 0;
    lane.touched = lane.touch_end = events.data();
    lane.started = kNever;
    if (prefetcher_) prefetcher_->begin_lane(id, message.slot, replay);
    if (stacks_) stacks_->begin(id, message.slot);
    if (shared_.header.checkpoint) {
      checkpoints_.begin(id, message.slot, message.round, replay, events, message.group->rays[i]);
    }
    warm(id, lane, call, before);
    if (lane.next != lane.end) call.active |= bit(i);
  });
  call.ready = call.active;
}

void RtUnit::retire(Cycle now, unsigned entry) {
  Call& call = calls_[entry];
  count_stall(shared_.agenda.now() + 1);
  count_wait(now + 1, call);
  const Cycle left = std::max(now + 1, call.since);
  counters_.warp_buffer.occupancy_integral += left - call.accepted;
  counters_.warp_buffer.warp_latency.add(left - call.accepted);
  free_entries_ |= bit(entry);
  occupied_ &= ~bit(entry);
  if (occupied_ != 0) oldest_ = OldestFirst::oldest(occupied_, ages_);
  shared_.agenda.add(now + 1 + shared_.config.sm_links.message_latency, {What::warp, sm_, call.slot});
  if (!waiting_calls_.empty()) accept(now + 1);
}

/// To be called when the lanes' states have changed. What is under way counts as waiting for memory until it has been
/// tested.
void RtUnit::count_wait(Cycle now, Call& call) {
  const LaneMask at_nodes =
      call.active & ~(call.waiting_any_hit | call.in_any_hit | call.checkpointing | call.stacking);
  const WarpWait wait = modules::wait_of(call.ready, at_nodes, call.checkpointing, call.stacking, 0, call.active);
  if (now > call.since) {
    counters_.warp_buffer.warp_cycles[static_cast<std::size_t>(call.wait)] += now - call.since;
    call.since = now;
  }
  call.wait = wait;
}

/// To be called before the state of the unit changes: no cycle before `until` that is not counted yet had a selection.
void RtUnit::count_stall(Cycle until) {
  if (until <= accounted_) return;
  const Stall reason = occupied_ == 0 ? Stall::empty : ready_ != 0 ? Stall::queue_full : stall_of(calls_[oldest_].wait);
  counters_.scheduler.stall[static_cast<std::size_t>(reason)] += until - accounted_;
  accounted_ = until;
  last_stall_ = reason;
}

/// The lane's next event waits for its warp's turn.
void RtUnit::make_ready(Cycle now, LaneId id, Call& call) {
  if (ready_ == 0) count_stall(now + 1);
  ready_ |= bit(entry_of(id));
  if (call.ready != 0) {
    call.ready |= lane_bit(id);
    return;
  }
  call.ready = lane_bit(id);
  count_wait(now + 1, call);
  select_soon(now);
}

Cycle RtUnit::room_from(Cycle now) {
  while (!leaving_.empty() && leaving_.front() <= now) leaving_.pop();
  const std::size_t fills = fetches_ + leaving_.size() + kMaxLanes;
  if (fills <= config_.memory.queue) return now;
  const std::size_t to_leave = fills - config_.memory.queue;
  return to_leave <= leaving_.size() ? leaving_[to_leave - 1] : kNever;
}

void RtUnit::select_soon(Cycle now) {
  if (select_timed_) return;
  const Cycle from = room_from(now + 1);
  if (from == kNever) return;
  select_timed_ = true;
  shared_.agenda.add(from, {What::selection, sm_, 0});
}

/// One warp a cycle: all its lanes that are ready.
void RtUnit::select(Cycle now) {
  select_timed_ = false;
  if (ready_ == 0) return;
  if (room_from(now) != now) return select_soon(now);
  count_stall(now);
  if (accounted_ > now) --counters_.scheduler.stall[static_cast<std::size_t>(last_stall_)];  // it is none after all
  accounted_ = now + 1;
  const unsigned entry = shared_.selection->select(ready_, ages_);
  Call& call = calls_[entry];
  const LaneMask lanes = call.ready;
  ++counters_.scheduler.selections;
  counters_.scheduler.lanes_handled += static_cast<unsigned>(std::popcount(lanes));
  counters_.scheduler.lanes_active += static_cast<unsigned>(std::popcount(call.active));
  call.ready = 0;
  ready_ &= ~bit(entry);
  if (prefetcher_) prefetcher_->begin_warp();
  const bool idle = l1_.idle(kNode);
  if (idle) l1_.hold(kNode, now + 2);
  LaneMask timed = lanes;
  if (shared_.stride > 1) {
    const Cycle apart = now - std::exchange(call.selected, now);
    for_each_bit(lanes, [&](unsigned i) {
      const LaneId id = lane_id(entry, i);
      Lane& lane = lanes_[id];
      if (warm_up_to_next(now, id, lane, call, apart)) return;
      timed &= ~bit(i);
      settled(now, id, lane, call);
    });
  }
  for_each_bit(timed, [&](unsigned i) {
    const LaneId id = lane_id(entry, i);
    if (spreads_) start_touches(now, id, lanes_[id], call);
    handle(now, id, lanes_[id], call);
  });
  if ((occupied_ & bit(entry)) != 0) count_wait(now, call);
  if (idle) l1_.serve(now);
  if (ready_ != 0) select_soon(now);
}

void RtUnit::handle(Cycle now, LaneId id, Lane& lane, Call& call) {
  const Event event = *lane.next;
  switch (event.kind()) {
    case EventKind::visit_internal:
      return fetch(now, id, lane, call, visit(id, event, call));
    case EventKind::visit_instance:
    case EventKind::visit_leaf:
      fetch(now, id, lane, call, visit(id, event, call));
      if (prefetcher_) prefetcher_->note_leaf(now, id, *call.group, event.node);
      return;
    case EventKind::cull:
      ++counters_.scheduler.culls;
      return complete(now, id, lane, EventEffect(event), call);
    default:
      if (!shared_.header.checkpoint) refuse(id, kRuleReplayNeedsCheckpoints);
      if (checkpoints_.read(now, id)) return replay(now, id, lane, call);
      call.checkpointing |= lane_bit(id);
  }
}

/// The source entry is there.
void RtUnit::replay(Cycle now, LaneId id, Lane& lane, Call& call) {
  const Event event = *lane.next;
  RtScheduler::Counters& counters = counters_.scheduler;
  if (prefetcher_ && event.kind() == EventKind::replay_take && !spreads_) {
    prefetcher_->note_replayed(id, event.node);
  }
  ++(event.kind() == EventKind::replay_take ? counters.replay_takes : counters.replay_forwards);
  complete(now, id, lane, EventEffect(event), call);
}

/// A node has been tested, a source entry has come, stack entries have moved, entries have been handed over, or the
/// any-hit shader has returned.
void RtUnit::lane_event(Cycle now, LaneId id) {
  Lane& lane = lanes_[id];
  Call& call = call_of(id);
  if (lane.settling) return settled(now, id, lane, call);
  if (std::exchange(lane.stacking, false)) {
    call.stacking &= ~lane_bit(id);
    return hand_over(now, id, lane, lane.checkpoints, call);
  }
  const Event event = *lane.next;
  const EventEffect effect(event);
  if (effect.replays()) {
    call.checkpointing &= ~lane_bit(id);
    return replay(now, id, lane, call);
  }
  if (lane.shaded) {
    lane.shaded = false;
    call.in_any_hit &= ~lane_bit(id);
    end_event(now, id, lane, effect.checkpoints(), call);
    if (call.in_any_hit == 0 && call.waiting_any_hit != 0) consider_any_hit(now, entry_of(id));
    return;
  }
  if (event.kind() == EventKind::visit_internal && prefetcher_ && !spreads_) {
    prefetcher_->note_internal(id, *call.group, event.node, event.pushed(), event.checkpoints);
  }
  if (!effect.calls_shader(boxes_)) return complete(now, id, lane, effect, call);
  move_stack(id, lane, effect);
  lane.shaded = true;
  any_hit_arrives(now, id, call);
}

void RtUnit::complete(Cycle now, LaneId id, Lane& lane, const EventEffect& effect, Call& call) {
  move_stack(id, lane, effect);
  end_event(now, id, lane, effect.checkpoints(), call);
}

void RtUnit::end_event(Cycle now, LaneId id, Lane& lane, unsigned checkpoints, Call& call) {
  ++lane.next;
  if (stacks_) {
    const Cycle moved = stacks_->settle(now, id, lane.depth, takes_top(lane));
    if (moved > now) {
      lane.stacking = true;
      lane.checkpoints = static_cast<std::uint8_t>(checkpoints);
      call.stacking |= lane_bit(id);
      if (moved != kNever) shared_.agenda.add(moved, {What::lane, sm_, id});
      return;
    }
  }
  hand_over(now, id, lane, checkpoints, call);
}

void RtUnit::hand_over(Cycle now, LaneId id, Lane& lane, unsigned checkpoints, Call& call) {
  if (shared_.header.checkpoint) {
    const Cycle taken = checkpoints_.write(now, id, checkpoints, lane.next == lane.end);
    if (taken > now) {
      lane.settling = true;
      call.checkpointing |= lane_bit(id);
      shared_.agenda.add(taken, {What::lane, sm_, id});
      return;
    }
  } else if (checkpoints != 0) {
    refuse(id, kRuleEntriesNeedCheckpoints);
  }
  settled(now, id, lane, call);
}

void RtUnit::settled(Cycle now, LaneId id, Lane& lane, Call& call) {
  if (lane.settling) {
    lane.settling = false;
    call.checkpointing &= ~lane_bit(id);
  }
  if (lane.end - lane.next <= lane.owed) warm(id, lane, call, lane.owed);
  if (lane.next != lane.end) return make_ready(now, id, call);
  call.active &= ~lane_bit(id);
  if (call.active == 0) {
    retire(now, entry_of(id));
  } else if (call.waiting_any_hit != 0) {
    consider_any_hit(now, entry_of(id));
  }
}

void RtUnit::any_hit_arrives(Cycle now, LaneId id, Call& call) {
  counters_.scheduler.any_hit_calls += EventEffect(*lanes_[id].next).calls_any_hit() ? 1 : 0;
  counters_.scheduler.intersection_calls += boxes_ ? 1 : 0;
  if (call.waiting_any_hit == 0) call.any_hit_since = now;
  call.waiting_any_hit |= lane_bit(id);
  if (call.wait == WarpWait::memory) count_wait(now, call);
  consider_any_hit(now, entry_of(id));
}

void RtUnit::consider_any_hit(Cycle now, unsigned entry) {
  Call& call = calls_[entry];
  if (call.in_any_hit != 0) return;
  const Cycle due = call.any_hit_since + config_.any_hit.timeout;
  if (call.waiting_any_hit == call.active || due <= now) return fire(now, entry);
  if (call.timing) return;
  call.timing = true;
  shared_.agenda.add(due, {What::any_hit_timer, sm_, entry});
}

void RtUnit::any_hit_due(Cycle now, unsigned entry) {
  calls_[entry].timing = false;
  if (calls_[entry].waiting_any_hit != 0) consider_any_hit(now, entry);
}

void RtUnit::fire(Cycle now, unsigned entry) {
  Call& call = calls_[entry];
  AnyHitBatch batch;
  batch.slot = call.slot;
  batch.round = call.round;
  for_each_bit(call.waiting_any_hit, [&](unsigned i) { add_lane(batch, i, *lanes_[lane_id(entry, i)].next); });
  AnyHitCollector::Counters& counters = counters_.any_hit;
  ++counters.batches;
  counters.lanes += static_cast<unsigned>(std::popcount(batch.lanes));
  if (batch.lanes != call.active) ++counters.timeouts;
  counters.wait_cycles += now - call.any_hit_since;
  call.in_any_hit = batch.lanes;
  call.waiting_any_hit = 0;
  simt_.serve(now + shared_.config.sm_links.message_latency, entry, batch);
}

void RtUnit::any_hit_done(Cycle seen, unsigned entry, LaneMask lanes) {
  for_each_bit(lanes, [&](unsigned i) { shared_.agenda.add(seen, {What::lane, sm_, lane_id(entry, i)}); });
}

void RtUnit::advance(Cycle now) {
  for (IntersectionPipelines* unit : {&box_, &leaf_, &transform_}) unit->advance(now);
  checkpoints_.advance(now);
  if (stacks_) stacks_->advance(now);
}

RtUnitCounters RtUnit::counters() const {
  RtUnitCounters counters = counters_;
  counters.ray_box = box_.counters();
  (shared_.traffic.leaf_kind() == NodeKind::triangle ? counters.ray_triangle : counters.ray_sphere) = leaf_.counters();
  counters.ray_transform = transform_.counters();
  counters.checkpoint = checkpoints_.counters();
  if (prefetcher_) counters.prefetch = prefetcher_->counters();
  if (stacks_) counters.stack = stacks_->counters();
  return counters;
}

}  // namespace grtx::sim::fast
