// Events that take no time. With a stride of n, one in n of a lane's events is simulated as always; the others happen
// at once, in between: they read and write the caches' tags and all state that later events depend on, but reserve
// nothing. So every warp meets the caches that it would meet, among as many others as always, and does a share of
// everything in that share of the time. Sampling with functional warming (SMARTS, Wunderlich et al., ISCA 2003), within
// each lane.
#include <bit>
#include <utility>

#include "grtx/rtl_tlm/estimate/fast/fast_rt_unit.h"
#include "grtx/rtl_tlm/estimate/fast/fast_simt.h"

namespace grtx::sim::fast {

using namespace modules;
using traces::Event;
using traces::EventKind;

void RtUnit::warm(LaneId id, Lane& lane, Call& call, unsigned count) {
  for (; count > 0 && lane.next != lane.end; --count) {
    if (lane.next >= lane.touched) {
      lane.touched = lane.next;
      touch_next(id, lane, call);
    }
    const Event event = *lane.next++;
    const EventEffect effect(event);
    switch (event.kind()) {
      case EventKind::visit_internal:
      case EventKind::visit_instance:
      case EventKind::visit_leaf:
        warm_visit(id, lane, call, event);
        break;
      case EventKind::cull:
        ++counters_.scheduler.culls;
        move_stack(id, lane, effect);
        break;
      default:
        if (!shared_.header.checkpoint) refuse(id, kRuleReplayNeedsCheckpoints);
        checkpoints_.warm_read(id);
        ++(event.kind() == EventKind::replay_take ? counters_.scheduler.replay_takes
                                                  : counters_.scheduler.replay_forwards);
        move_stack(id, lane, effect);
    }
    if (stacks_) stacks_->warm(id, lane.depth, takes_top(lane));
    const unsigned checkpoints = effect.checkpoints();
    if (shared_.header.checkpoint) {
      checkpoints_.warm_write(id, checkpoints, lane.next == lane.end);
    } else if (checkpoints != 0) {
      refuse(id, kRuleEntriesNeedCheckpoints);
    }
  }
}

void RtUnit::warm_visit(LaneId id, Lane& lane, Call& call, const Event& event) {
  const NodeSectors sectors(visit(id, event, call), shared_.traffic);
  ++counters_.memory.visits[static_cast<std::size_t>(sectors.region())];
  const EventEffect effect(event);
  move_stack(id, lane, effect);
  if (!effect.calls_shader(boxes_)) return;
  counters_.scheduler.any_hit_calls += effect.calls_any_hit() ? 1 : 0;
  counters_.scheduler.intersection_calls += boxes_ ? 1 : 0;
  AnyHitBatch batch;
  batch.slot = call.slot;
  batch.round = call.round;
  add_lane(batch, lane_of(id), event);
  simt_.warm_any_hit(batch);
}

void RtUnit::touch_next(LaneId id, Lane& lane, const Call& call) {
  const Event event = *lane.touched++;
  switch (event.kind()) {
    case EventKind::visit_internal:
    case EventKind::visit_instance:
    case EventKind::visit_leaf: {
      const std::optional<NodeVisit> node = node_visit(event, *call.group, shared_.traffic);
      if (!node) return;  // refused when it happens
      NodeSectors(*node, shared_.traffic).for_each_run([&](const SectorRun& run, bool /*last*/) {
        if (!run.again) l1_.warm(kNode, run);
      });
      if (!prefetcher_) return;
      if (event.kind() == EventKind::visit_internal) {
        prefetcher_->note_internal(id, *call.group, event.node, event.pushed(), event.checkpoints);
      } else {
        prefetcher_->warm_leaf(id, *call.group, event.node);
      }
      return;
    }
    case EventKind::replay_take:
      if (prefetcher_) prefetcher_->note_replayed(id, event.node);
      return;
    default:
      return;
  }
}

void RtUnit::start_touches(Cycle now, LaneId id, Lane& lane, const Call& call) {
  if (lane.started != kNever) usual_step_ += now - lane.started - usual_step_ / 16;
  lane.started = now;
  if (lane.touched <= lane.next) {
    // What the prefetcher is to know before the events behind this one: these may be touched before it has ended.
    const Event event = *lane.next;
    if (prefetcher_ && event.kind() == EventKind::visit_internal) {
      prefetcher_->note_internal(id, *call.group, event.node, event.pushed(), event.checkpoints);
    }
    if (prefetcher_ && event.kind() == EventKind::replay_take) prefetcher_->note_replayed(id, event.node);
    lane.touched = lane.next + 1;
  }
  const std::ptrdiff_t behind =
      std::min<std::ptrdiff_t>(lane.end - lane.next - 1, lane.owed + static_cast<std::ptrdiff_t>(shared_.stride) - 1);
  lane.touch_end = lane.next + 1 + behind;
  if (lane.touched >= lane.touch_end) return;
  lane.pace = std::max<Cycle>(1, usual_step_ / 16 / static_cast<Cycle>(behind + 1));
  if (std::exchange(lane.touching, true)) return;
  shared_.agenda.add(now + lane.pace, {What::touch, sm_, id});
}

void RtUnit::touch(Cycle now, LaneId id) {
  Lane& lane = lanes_[id];
  lane.touching = false;
  if (lane.next == lane.end || lane.touched >= lane.touch_end) return;
  touch_next(id, lane, call_of(id));
  if (lane.touched >= lane.touch_end) return;
  lane.touching = true;
  shared_.agenda.add(now + lane.pace, {What::touch, sm_, id});
}

// One of each `stride` events of a lane takes time. It is the last, unless an earlier one visits a node that its warp
// is fetching already: then that one does, and joins the fetch, and the rest follow with the next. Else lanes that are
// a little behind others would join them more seldom than they do, since each step takes them further.
bool RtUnit::warm_up_to_next(Cycle now, LaneId id, Lane& lane, Call& call, Cycle apart) {
  if (std::exchange(lane.begins, false)) return true;
  warm(id, lane, call, std::exchange(lane.owed, std::uint16_t{0}));
  for (unsigned i = 0; i + 1 < shared_.stride && lane.next != lane.end; ++i) {
    if (is_under_way(*lane.next, call, now, now + i * apart)) {
      lane.owed = static_cast<std::uint16_t>(shared_.stride - 1 - i);
      return true;
    }
    warm(id, lane, call, 1);
  }
  return lane.next != lane.end;
}

// Not of a shared BLAS: its nodes are under way all the time, and lanes meet there that are not on one path.
bool RtUnit::is_under_way(const Event& event, const Call& call, Cycle now, Cycle then) const {
  if (!config_.memory.merge_in_flight) return false;  // nobody joins
  const std::optional<NodeVisit> node = node_visit(event, *call.group, shared_.traffic);
  if (!node || shared_.traffic.region(node->kind, node->address) == Region::blas) return false;
  const NodeFetches& fetches = call.fetches;
  for (std::uint32_t same = fetches.of_node(NodeFetches::key_of(*node)); same != 0; same &= same - 1) {
    const auto leader = static_cast<unsigned>(std::countr_zero(same));
    if (fetches.lanes[leader] != 0 ? then == now : fetches.ready[leader].at(now) > then) return true;
  }
  return false;
}

}  // namespace grtx::sim::fast
