// The RT unit in fast mode: calls, the order of warps, and what becomes of a lane's events.
#include <bit>
#include <utility>

#include "grtx/modules/rt_unit/policies/oldest_first.h"
#include "grtx/rtl_tlm/estimate/fast/fast_machine.h"

namespace grtx::sim::fast {

using namespace modules;
using traces::Event;
using traces::EventKind;

void Machine::accept(Cycle now, unsigned s) {
  Sm& sm = sms_[s];
  while (sm.free_entries != 0 && !sm.waiting_calls.empty()) {
    const unsigned slot = sm.waiting_calls.front();
    sm.waiting_calls.pop();
    const auto entry = static_cast<unsigned>(std::countr_zero(sm.free_entries));
    Warp& warp = sm.warps[slot];
    warp.entry = entry;
    const std::uint32_t round = sm.program.round(slot);
    warp.cursor.seek(*warp.group, round);
    Call& call = sm.calls[entry];
    call.slot = static_cast<std::uint16_t>(slot);
    call.active = call.ready = call.waiting_any_hit = call.in_any_hit = call.checkpointing = 0;
    call.fetches.clear(now);
    const auto before = static_cast<unsigned>(draw() % stride_);  // events of each lane, without time
    for_each_bit(sm.program.active_lanes(slot), [&](unsigned i) {
      const auto events = warp.cursor.events(i);
      if (events.empty()) return;
      const bool replay = warp.cursor.round(i).replay;
      const Number number = lane_number(s, entry, i);
      Lane& lane = lanes_[number];
      lane.next = events.data();
      lane.end = events.data() + events.size();
      lane.depth = replay ? 0 : 1;  // a round that does not replay starts with the root on the stack
      lane.shaded = lane.settling = false;
      lane.begins = true;
      lane.owed = 0;
      if (records_) records_->begin(number);
      if (header_.checkpoint) begin_checkpoints(s, slot, i, round, number, replay);
      warm(number, lane, sm, call, before);
      if (lane.next != lane.end) call.active |= bit(i);
    });
    call.ready = call.active;
    call.accepted = call.since = call.selected = now;
    call.wait = call.ready != 0 ? WarpWait::ready : WarpWait::retire;
    count_stall(wheel_.now(), sm);
    sm.free_entries &= ~bit(entry);
    if (sm.occupied == 0) sm.oldest = entry;
    sm.occupied |= bit(entry);
    sm.ages[entry] = next_age_++;
    ++sm.rt.warp_buffer.calls;
    if (call.ready != 0) {
      sm.ready |= bit(entry);
      select_soon(now, s, sm);
    } else {
      retire(now, s, entry);
    }
  }
}

void Machine::retire(Cycle now, unsigned s, unsigned entry) {
  Sm& sm = sms_[s];
  Call& call = sm.calls[entry];
  count_stall(wheel_.now() + 1, sm);
  count_wait(now + 1, sm, call);
  const Cycle left = std::max(now + 1, call.since);
  sm.rt.warp_buffer.occupancy_integral += left - call.accepted;
  sm.rt.warp_buffer.warp_latency.add(left - call.accepted);
  sm.free_entries |= bit(entry);
  sm.occupied &= ~bit(entry);
  if (sm.occupied != 0) sm.oldest = OldestFirst::oldest(sm.occupied, sm.ages);
  wheel_.add(now + 1 + config_.sm_links.message_latency, warp_number(s, call.slot));
  if (!sm.waiting_calls.empty()) accept(now + 1, s);
}

/// To be called when the lanes' states have changed. What is under way counts as waiting for memory until it has been
/// tested.
void Machine::count_wait(Cycle now, Sm& sm, Call& call) {
  WarpWait wait = WarpWait::retire;
  if (call.ready != 0) {
    wait = WarpWait::ready;
  } else if ((call.active & ~(call.waiting_any_hit | call.in_any_hit | call.checkpointing)) != 0) {
    wait = WarpWait::memory;
  } else if (call.checkpointing != 0) {
    wait = WarpWait::checkpoint;
  } else if (call.active != 0) {
    wait = WarpWait::any_hit;
  }
  if (now > call.since) {
    sm.rt.warp_buffer.warp_cycles[static_cast<std::size_t>(call.wait)] += now - call.since;
    call.since = now;
  }
  call.wait = wait;
}

/// To be called before the state of the unit changes: no cycle before `until` that is not counted yet had a selection.
void Machine::count_stall(Cycle until, Sm& sm) {
  if (until <= sm.accounted) return;
  Stall reason = Stall::retire;
  if (sm.occupied == 0) {
    reason = Stall::empty;
  } else if (sm.ready != 0) {
    reason = Stall::queue_full;
  } else {
    const WarpWait wait = sm.calls[sm.oldest].wait;
    if (wait == WarpWait::memory) reason = Stall::memory;
    if (wait == WarpWait::checkpoint) reason = Stall::checkpoint;
    if (wait == WarpWait::any_hit) reason = Stall::any_hit;
  }
  sm.rt.scheduler.stall[static_cast<std::size_t>(reason)] += until - sm.accounted;
  sm.accounted = until;
  sm.last_stall = reason;
}

/// The lane's next event waits for its warp's turn.
void Machine::make_ready(Cycle now, Number number, const Lane& lane, Sm& sm, Call& call) {
  if (sm.ready == 0) count_stall(now + 1, sm);
  sm.ready |= bit(lane.entry);
  if (call.ready != 0) {
    call.ready |= lane_bit(number);
    return;
  }
  call.ready = lane_bit(number);
  count_wait(now + 1, sm, call);
  select_soon(now, lane.sm, sm);
}

Cycle Machine::room_from(Cycle now, Sm& sm) const {
  while (!sm.leaving.empty() && sm.leaving.front() <= now) sm.leaving.pop();
  const std::size_t fills = sm.fetches + sm.leaving.size() + kMaxLanes;
  if (fills <= config_.rt.memory.queue) return now;
  const std::size_t to_leave = fills - config_.rt.memory.queue;
  return to_leave <= sm.leaving.size() ? sm.leaving[to_leave - 1] : kNever;
}

void Machine::select_soon(Cycle now, unsigned s, Sm& sm) {
  if (sm.select_timed) return;
  const Cycle from = room_from(now + 1, sm);
  if (from == kNever) return;
  sm.select_timed = true;
  wheel_.add(from, selects_from_ + s);
}

/// One warp a cycle: all its lanes that are ready.
void Machine::select(Cycle now, unsigned s) {
  Sm& sm = sms_[s];
  sm.select_timed = false;
  if (sm.ready == 0) return;
  if (room_from(now, sm) != now) return select_soon(now, s, sm);
  count_stall(now, sm);
  if (sm.accounted > now) --sm.rt.scheduler.stall[static_cast<std::size_t>(sm.last_stall)];  // it is none after all
  sm.accounted = now + 1;
  const unsigned entry = selection_->select(sm.ready, sm.ages);
  Call& call = sm.calls[entry];
  const LaneMask lanes = call.ready;
  RtScheduler::Counters& counters = sm.rt.scheduler;
  ++counters.selections;
  counters.lanes_handled += static_cast<unsigned>(std::popcount(lanes));
  counters.lanes_active += static_cast<unsigned>(std::popcount(call.active));
  call.ready = 0;
  sm.ready &= ~bit(entry);
  requests_.begin();
  const bool idle = sm.ports[kNode].queue.empty();
  if (idle) sm.ports[kNode].next = std::max(sm.ports[kNode].next, now + 2);
  LaneMask timed = lanes;
  if (stride_ > 1) {
    const Cycle apart = now - std::exchange(call.selected, now);
    for_each_bit(lanes, [&](unsigned i) {
      const Number number = lane_number(s, entry, i);
      Lane& lane = lanes_[number];
      if (warm_up_to_next(now, number, lane, sm, call, apart)) return;
      timed &= ~bit(i);
      settled(now, number, lane, sm, call);
    });
  }
  for_each_bit(timed, [&](unsigned i) {
    const Number number = lane_number(s, entry, i);
    handle(now, number, lanes_[number], sm, call);
  });
  if ((sm.occupied & bit(entry)) != 0) count_wait(now, sm, call);
  if (idle) serve(now, s);
  if (sm.ready != 0) select_soon(now, s, sm);
}

void Machine::handle(Cycle now, Number number, Lane& lane, Sm& sm, Call& call) {
  const Event event = *lane.next;
  switch (event.kind()) {
    case EventKind::visit_internal:
      return fetch(now, number, lane, sm, call, visit(number, event, sm, call));
    case EventKind::visit_instance:
    case EventKind::visit_leaf:
      fetch(now, number, lane, sm, call, visit(number, event, sm, call));
      if (!records_) return;
      if (const Siblings siblings = records_->take(number, group_of(lane), event.node); siblings.mask != 0) {
        prefetch_siblings(now, lane, sm, siblings);
      }
      return;
    case EventKind::cull:
      ++sm.rt.scheduler.culls;
      return complete(now, number, lane, EventEffect(event), sm, call);
    default:
      if (!header_.checkpoint) refuse(number, kRuleReplayNeedsCheckpoints);
      if (read_checkpoint(now, number)) return replay(now, number, lane, sm, call);
      call.checkpointing |= lane_bit(number);
  }
}

/// The source entry is there.
void Machine::replay(Cycle now, Number number, Lane& lane, Sm& sm, Call& call) {
  const Event event = *lane.next;
  ++(event.kind() == EventKind::replay_take ? sm.rt.scheduler.replay_takes : sm.rt.scheduler.replay_forwards);
  complete(now, number, lane, EventEffect(event), sm, call);
}

/// A node has been tested, a source entry has come, entries have been handed over, or the any-hit shader has returned.
void Machine::lane_event(Cycle now, Number number, Lane& lane) {
  Sm& sm = sms_[lane.sm];
  Call& call = sm.calls[lane.entry];
  if (lane.settling) return settled(now, number, lane, sm, call);
  const Event event = *lane.next;
  const EventEffect effect(event);
  if (effect.replays()) {
    call.checkpointing &= ~lane_bit(number);
    return replay(now, number, lane, sm, call);
  }
  if (lane.shaded) {
    lane.shaded = false;
    call.in_any_hit &= ~lane_bit(number);
    end_event(now, number, lane, 0, sm, call);
    if (call.in_any_hit == 0 && call.waiting_any_hit != 0) consider_any_hit(now, lane.sm, lane.entry);
    return;
  }
  if (event.kind() == EventKind::visit_internal && records_) {
    records_->note(number, group_of(lane), event.node, event.pushed());
  }
  if (!effect.calls_any_hit()) return complete(now, number, lane, effect, sm, call);
  move_stack(number, lane, effect, sm);
  lane.shaded = true;
  any_hit_arrives(now, number, lane, sm, call);
}

void Machine::complete(Cycle now, Number number, Lane& lane, const EventEffect& effect, Sm& sm, Call& call) {
  move_stack(number, lane, effect, sm);
  end_event(now, number, lane, effect.checkpoints(), sm, call);
}

void Machine::end_event(Cycle now, Number number, Lane& lane, unsigned checkpoints, Sm& sm, Call& call) {
  ++lane.next;
  if (header_.checkpoint) {
    const Cycle taken = write_checkpoints(now, number, checkpoints, lane.next == lane.end);
    if (taken > now) {
      lane.settling = true;
      call.checkpointing |= lane_bit(number);
      wheel_.add(taken, number);
      return;
    }
  } else if (checkpoints != 0) {
    refuse(number, kRuleEntriesNeedCheckpoints);
  }
  settled(now, number, lane, sm, call);
}

void Machine::settled(Cycle now, Number number, Lane& lane, Sm& sm, Call& call) {
  if (lane.settling) {
    lane.settling = false;
    call.checkpointing &= ~lane_bit(number);
  }
  if (lane.end - lane.next <= lane.owed) warm(number, lane, sm, call, lane.owed);
  if (lane.next != lane.end) return make_ready(now, number, lane, sm, call);
  call.active &= ~lane_bit(number);
  if (call.active == 0) {
    retire(now, lane.sm, lane.entry);
  } else if (call.waiting_any_hit != 0) {
    consider_any_hit(now, lane.sm, lane.entry);
  }
}

void Machine::any_hit_arrives(Cycle now, Number number, const Lane& lane, Sm& sm, Call& call) {
  ++sm.rt.scheduler.any_hit_calls;
  if (call.waiting_any_hit == 0) call.any_hit_since = now;
  call.waiting_any_hit |= lane_bit(number);
  if (call.wait == WarpWait::memory) count_wait(now, sm, call);
  consider_any_hit(now, lane.sm, lane.entry);
}

void Machine::consider_any_hit(Cycle now, unsigned s, unsigned entry) {
  Call& call = sms_[s].calls[entry];
  if (call.in_any_hit != 0) return;
  const Cycle due = call.any_hit_since + config_.rt.any_hit.timeout;
  if (call.waiting_any_hit == call.active || due <= now) return fire(now, s, entry);
  if (call.timing) return;
  call.timing = true;
  wheel_.add(due, timers_from_ + s * entries_ + entry);
}

void Machine::fire(Cycle now, unsigned s, unsigned entry) {
  Sm& sm = sms_[s];
  Call& call = sm.calls[entry];
  Warp& warp = sm.warps[call.slot];
  AnyHitBatch batch;
  batch.slot = call.slot;
  batch.round = sm.program.round(call.slot);
  for_each_bit(call.waiting_any_hit, [&](unsigned i) { add_lane(batch, i, *lanes_[lane_number(s, entry, i)].next); });
  AnyHitCollector::Counters& counters = sm.rt.any_hit;
  ++counters.batches;
  counters.lanes += static_cast<unsigned>(std::popcount(batch.lanes));
  if (batch.lanes != call.active) ++counters.timeouts;
  counters.wait_cycles += now - call.any_hit_since;
  call.in_any_hit = warp.service_lanes = batch.lanes;
  call.waiting_any_hit = 0;
  warp.in_service = true;
  any_hit(sm, batch, sm.timed_any_hits);
  load(now + config_.sm_links.message_latency, s, call.slot);
}

}  // namespace grtx::sim::fast
