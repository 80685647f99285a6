#include "rtl_tlm/fast/fast_rt_unit.h"

#include <algorithm>
#include <bit>

#include "base/error.h"

namespace grtx::tlm {

using namespace modules;
using traces::Event;
using traces::EventKind;
using traces::NodeKind;

FastRtUnit::FastRtUnit(const std::string& name, const RtUnitConfig& config, const traces::Header& header,
                       const MemoryMap& map, unsigned sm, FastL1& l1, const Links& links)
    : config_(config),
      l1_(l1),
      links_(links),
      traffic_(header, config.memory.traffic),
      selection_(make_warp_selection(config.scheduler.policy)),
      warps_(config.warp_buffer.entries),
      ages_(config.warp_buffer.entries),
      times_(config.warp_buffer.entries),
      fetches_(config.warp_buffer.entries),
      queue_(config.memory.queue),
      hits_(l1.latency()),
      results_(std::size_t{config.warp_buffer.entries} * kMaxLanes),
      box_(config.ray_box),
      leaf_(traffic_.leaf_kind() == NodeKind::triangle ? config.ray_triangle : config.ray_sphere),
      transform_(config.ray_transform) {
  const unsigned entries = config.warp_buffer.entries;
  all_ = entries == 64 ? ~LaneMask{0} : bit(entries) - 1;
  if (header.checkpoint) {
    checkpoint_ = std::make_unique<CheckpointUnit>((name + "_checkpoint_unit").c_str(), config.checkpoint, map,
                                                   header.checkpoint_order, header.checkpoint_capacity, entries, sm);
  }
  if (config.sibling_prefetch) {
    prefetcher_ = std::make_unique<SiblingPrefetcher>((name + "_sibling_prefetcher").c_str(), config.prefetcher,
                                                      traffic_, entries);
  }
}

void FastRtUnit::refuse(LaneId id, const char* rule) const {
  const Warp& warp = warps_[entry_of(id)];
  throw Error("trace",
              "group " + std::to_string(warp.group->index) + " lane " + std::to_string(lane_of(id)) + " round " +
                  std::to_string(warp.round),
              rule);
}

Cycle FastRtUnit::Unit::test(Cycle ready, unsigned tests) {
  Cycle start = places.reserve(ready + 1);
  counters.queue_cycles += start - (ready + 1);
  ++counters.operations;
  counters.tests += tests;
  counters.busy_cycles += Cycle{tests} * config.interval;
  for (unsigned i = 1; i < tests; ++i) start = places.reserve(start + config.interval);
  return start + config.latency;
}

void FastRtUnit::count_wait(Cycle end, unsigned entry) {
  Times& times = times_[entry];
  if (end <= times.since) return;
  buffer_counters_.warp_cycles[static_cast<std::size_t>(times.wait)] += end - times.since;
  times.since = end;
}

void FastRtUnit::move(Cycle now, unsigned entry, LaneMask lanes, LaneState from, LaneState to) {
  const LaneMask b = bit(entry);
  if ((touched_ & b) == 0) {
    count_wait(now + 1, entry);
    touched_ |= b;
  }
  Warp& w = warps_[entry];
  w.in[static_cast<std::size_t>(from)] &= ~lanes;
  w.in[static_cast<std::size_t>(to)] |= lanes;
  ready_ = w.in_state(LaneState::ready) != 0 ? ready_ | b : ready_ & ~b;
  if (w.in_state(LaneState::finished) == w.lanes) done_ |= b;
}

void FastRtUnit::refresh_waits() {
  for_each_bit(touched_ & occupied_, [&](unsigned entry) { times_[entry].wait = warps_[entry].wait(); });
  touched_ = 0;
}

Stall FastRtUnit::stall_reason() const {
  if (occupied_ == 0) return Stall::empty;
  if (ready_ != 0) return Stall::queue_full;
  switch (warps_[oldest(occupied_)].wait()) {
    case WarpWait::memory:
      return Stall::memory;
    case WarpWait::checkpoint:
      return Stall::checkpoint;
    case WarpWait::unit:
      return Stall::unit;
    case WarpWait::any_hit:
      return Stall::any_hit;
    default:
      return Stall::retire;
  }
}

void FastRtUnit::step(Cycle now) {
  if (now > accounted_) scheduler_counters_.stall[static_cast<std::size_t>(stall_reason())] += now - accounted_;
  accounted_ = now + 1;
  results_.take(now, [&](LaneId id) { unit_result(now, id); });
  if (checkpoint_) {
    if (const auto id = checkpoint_->respond(now, *links_.checkpoint_responses)) {
      replay(now, *id, LaneState::waiting_checkpoint_read);
    }
    checkpoint_->issue(now, *links_.checkpoint_requests);
    checkpoint_->accept([&](LaneId id) {
      const Lane& l = lane(id);
      move(now, entry_of(id), bit(lane_of(id)), LaneState::waiting_checkpoint_write,
           l.left == 0 ? LaneState::finished : LaneState::ready);
    });
  }
  any_hit_returns(now);
  if (candidates_ != 0) fire(now);
  if (done_ != 0) retire(now);
  schedule(now);
  ask(now);
  accept(now);
  refresh_waits();
  due_ = next_due(now);
  prefetch_host();
}

// The host has long dropped what the next lane will read.
void FastRtUnit::prefetch_host() const {
  const DueWheel::Number id = results_.peek();
  if (id == DueWheel::kNone) return;
  const Warp& warp = warps_[entry_of(id)];
  const Lane& l = warp.lane[lane_of(id)];
  prefetch_for_read(l.next + 2);
  if (prefetcher_) prefetcher_->prefetch_host(id);
  const auto& nodes = warp.group->nodes;
  if (l.event.kind() == EventKind::visit_internal) prefetch_for_read(&nodes[l.event.node]);
  if (l.left < 2) return;
  if (l.following.kind() == EventKind::visit_internal) {
    if (l.following.node < nodes.size()) prefetch_for_read(&nodes[l.following.node]);
  } else if (l.following.kind() == EventKind::visit_leaf) {
    l1_.prefetch_host(std::uint64_t{l.following.node} * traces::kNodeUnit);
  }
}

void FastRtUnit::schedule(Cycle now) {
  if (ready_ == 0 || !has_room()) {
    ++scheduler_counters_.stall[static_cast<std::size_t>(stall_reason())];
    return;
  }
  const unsigned entry = selection_->select(ready_, ages_);
  const Warp& warp = warps_[entry];
  const LaneMask lanes = warp.in_state(LaneState::ready);
  ++scheduler_counters_.selections;
  scheduler_counters_.lanes_handled += static_cast<unsigned>(std::popcount(lanes));
  scheduler_counters_.lanes_active += static_cast<unsigned>(std::popcount(warp.active()));
  if (prefetcher_) prefetcher_->begin_warp();
  LaneMask fetching = 0;
  for_each_bit(lanes, [&](unsigned i) {
    const LaneId id = lane_id(entry, i);
    const Event event = warp.lane[i].event;
    switch (event.kind()) {
      case EventKind::visit_internal:
      case EventKind::visit_instance:
      case EventKind::visit_leaf:
        visit(now, id, event);
        fetching |= bit(i);
        break;
      case EventKind::cull:
        ++scheduler_counters_.culls;
        pop(id);
        complete(now, id, event.checkpoints, LaneState::ready);
        break;
      default:
        if (!checkpoint_) refuse(id, "replays although checkpointing is off");
        if (checkpoint_->read(id)) {
          replay(now, id, LaneState::ready);
        } else {
          move(now, entry, bit(i), LaneState::ready, LaneState::waiting_checkpoint_read);
        }
    }
  });
  if (fetching != 0) move(now, entry, fetching, LaneState::ready, LaneState::waiting_memory);
}

void FastRtUnit::visit(Cycle now, LaneId id, const Event& event) {
  const traces::RayGroup& group = *warps_[entry_of(id)].group;
  switch (event.kind()) {
    case EventKind::visit_internal:
      if (event.node >= group.nodes.size()) refuse(id, "visits an internal node that the group does not define");
      ++scheduler_counters_.visits_internal;
      fetch(now, id, NodeKind::internal, std::uint64_t{group.nodes[event.node].address} * traces::kNodeUnit, false);
      return;
    case EventKind::visit_instance:
      if (!traffic_.two_level()) refuse(id, "visits an instance leaf of a monolithic structure");
      ++scheduler_counters_.visits_instance;
      fetch(now, id, NodeKind::instance, std::uint64_t{event.node} * traces::kNodeUnit,
            event.detail == 0 && traffic_.header_read());
      break;
    default:
      ++scheduler_counters_.visits_leaf;
      fetch(now, id, traffic_.leaf_kind(), std::uint64_t{event.node} * traces::kNodeUnit, false);
  }
  if (prefetcher_) prefetcher_->note_leaf(id, group, event.node);
}

void FastRtUnit::fetch(Cycle now, LaneId id, NodeKind kind, std::uint64_t address, bool header) {
  const auto region = static_cast<std::size_t>(traffic_.region(kind, address));
  ++memory_counters_.visits[region];
  const unsigned entry = entry_of(id);
  // A visit joins a fetch of its warp that is under way, or without merging in flight one that begins in this cycle.
  const std::uint64_t key = address / kSectorBytes << 1 | (header ? 1u : 0u);
  FetchTable& table = fetches_[entry];
  const std::size_t home = (key * 0x9E3779B97F4A7C15u) >> 58;
  static_assert(kPlaces == 64);
  std::size_t place = home;
  bool found = false;
  for (std::size_t i = 0; !found && (i < kProbes || table[place].ready == kNever); ++i) {
    const std::size_t probe = (home + i) % kPlaces;
    const Fetch& f = table[probe];
    found = f.key == key && (config_.memory.merge_in_flight ? f.ready > now : f.asked == now);
    if (found || f.ready < table[place].ready) place = probe;
  }
  Fetch& f = table[place];
  prefetch_for_read(warps_[entry].lane[lane_of(id)].next + 2);
  if (found && f.ready != kNever) return await_result(now, id, kind, f.ready);
  if (!found) {
    ++memory_counters_.fetches[region];
    f = {key, now, kNever, 0};
    queue_.push({address, 0, id, static_cast<std::uint8_t>(place), kind, header,
                 static_cast<std::uint8_t>(sectors_of(kind, header))});
    l1_.prefetch_host(address);
  }
  f.lanes |= bit(lane_of(id));
}

void FastRtUnit::await_result(Cycle now, LaneId id, NodeKind kind, Cycle ready) {
  unsigned tests = 1;
  if (config_.box_op_per_child && kind == NodeKind::internal) {
    const Warp& warp = warps_[entry_of(id)];
    tests = std::max(1u, unsigned{warp.group->nodes[warp.lane[lane_of(id)].event.node].child_count});
  }
  Unit& unit = kind == NodeKind::internal ? box_ : kind == NodeKind::instance ? transform_ : leaf_;
  results_.add(now, unit.test(ready, tests), id);
}

// Node requests and prefetches have a port at the L1 each, which takes one a cycle. They ask ahead of time, unless the
// L1 is slow: then its other clients come in between.
void FastRtUnit::ask(Cycle now) {
  ask_.next += l1_.take_overtaken();
  while (!queue_.empty() && ask_.may(now)) {
    Waiting& waiting = queue_.front();
    const unsigned entry = entry_of(waiting.lane);
    Fetch& f = fetches_[entry][waiting.place];
    // The first leaves in the cycle after the visit and is at the L1 one later.
    const Cycle at = std::max({ask_.next, f.asked + 2, hits_[next_hit_]});
    const MemoryRequest request = next_sector(waiting);
    const FastL1::Access access = l1_.access(at, request, FastL1::kNode);
    if (!ask_.answered(access)) break;
    --waiting.left;
    ++memory_counters_.sectors[static_cast<std::size_t>(request.region)];
    const Cycle response = responses_.reserve(access.seen);
    if (access.hit) {
      hits_[next_hit_] = response;
      next_hit_ = next_hit_ + 1 == hits_.size() ? 0 : next_hit_ + 1;
    }
    waiting.seen = std::max(waiting.seen, response);
    if (waiting.left > 0) continue;
    f.ready = waiting.seen;
    memory_counters_.fetch_latency.add(f.ready - f.asked);
    for_each_bit(f.lanes, [&](unsigned i) { await_result(now, lane_id(entry, i), waiting.kind, f.ready); });
    f.lanes = 0;
    queue_.pop();
  }
  if (!prefetcher_) return;
  while (prefetch_.may(now) && (prefetching_ || prefetcher_->next(prefetched_))) {
    const Cycle at = std::max(prefetch_.next, now + 1);
    prefetching_ = !prefetch_.answered(l1_.access(at, prefetched_, FastL1::kPrefetch));
  }
}

unsigned FastRtUnit::sectors_of(NodeKind kind, bool header) const {
  const bool leaf = kind == NodeKind::triangle || kind == NodeKind::procedural;
  return traffic_.sectors(kind) + (leaf && traffic_.descriptor_read() ? 1 : 0) +
         (header ? static_cast<unsigned>(traces::kHeaderBytes / kSectorBytes) : 0);
}

// A fetch's sectors in the order of MemoryScheduler: descriptor (if any), the node's, the BLAS header (if any).
MemoryRequest FastRtUnit::next_sector(const Waiting& fetch) const {
  const unsigned body = traffic_.sectors(fetch.kind);
  const unsigned after = fetch.header ? static_cast<unsigned>(traces::kHeaderBytes / kSectorBytes) : 0;
  const unsigned left = fetch.left;
  MemoryRequest request;
  if (left <= after) {
    request.address = traffic_.blas_header() + kSectorBytes * (after - left);
    request.region = Region::blas;
  } else {
    request.address = fetch.address + (left > after + body ? 0 : kSectorBytes * (after + body - left));
    request.region = traffic_.region(fetch.kind, fetch.address);
  }
  return request;
}

void FastRtUnit::pop(LaneId id) {
  Lane& l = lane(id);
  if (l.stack_depth == 0) refuse(id, "takes a node from an empty stack");
  --l.stack_depth;
}

void FastRtUnit::unit_result(Cycle now, LaneId id) {
  Lane& l = lane(id);
  const Event event = l.event;
  switch (event.kind()) {
    case EventKind::visit_internal:
      pop(id);
      l.stack_depth += static_cast<unsigned>(std::popcount(event.pushed()));
      buffer_counters_.max_stack_depth = std::max<std::uint64_t>(buffer_counters_.max_stack_depth, l.stack_depth);
      if (prefetcher_) prefetcher_->note_internal(id, *warps_[entry_of(id)].group, event.node, event.pushed());
      complete(now, id, static_cast<unsigned>(std::popcount(unsigned{event.checkpoints})), LaneState::waiting_memory);
      return;
    case EventKind::visit_instance:
      if (l.stack_depth == 0) refuse(id, "takes a node from an empty stack");
      complete(now, id, 0, LaneState::waiting_memory);
      return;
    default:
      pop(id);
      if (traces::calls_any_hit(event.outcome())) {
        ++scheduler_counters_.any_hit_calls;
        any_hit_arrives(now, id);
      } else {
        complete(now, id, event.checkpoints, LaneState::waiting_memory);
      }
  }
}

void FastRtUnit::replay(Cycle now, LaneId id, LaneState from) {
  Lane& l = lane(id);
  const Event event = l.event;
  if (event.kind() == EventKind::replay_take) {
    ++scheduler_counters_.replay_takes;
    ++l.stack_depth;
    buffer_counters_.max_stack_depth = std::max<std::uint64_t>(buffer_counters_.max_stack_depth, l.stack_depth);
    complete(now, id, 0, from);
  } else {
    ++scheduler_counters_.replay_forwards;
    complete(now, id, event.checkpoints, from);
  }
}

void FastRtUnit::complete(Cycle now, LaneId id, unsigned checkpoints, LaneState from) {
  Lane& l = lane(id);
  const bool last = !l.advance();
  if (!last && l.event.kind() == EventKind::visit_internal) {
    const auto& nodes = warps_[entry_of(id)].group->nodes;
    if (l.event.node < nodes.size()) prefetch_for_read(&nodes[l.event.node]);
  }
  LaneState to = last ? LaneState::finished : LaneState::ready;
  if (checkpoint_) {
    if (checkpoint_->submit(id, checkpoints, last)) to = LaneState::waiting_checkpoint_write;
  } else if (checkpoints != 0) {
    refuse(id, "writes checkpoint entries although checkpointing is off");
  }
  if (to != from) move(now, entry_of(id), bit(lane_of(id)), from, to);
}

void FastRtUnit::any_hit_arrives(Cycle now, LaneId id) {
  const unsigned entry = entry_of(id);
  Warp& warp = warps_[entry];
  if (warp.in_state(LaneState::waiting_any_hit) == 0) {
    warp.any_hit_since = now;
    if (warp.in_state(LaneState::in_any_hit) == 0) candidates_ |= bit(entry);
  }
  move(now, entry, bit(lane_of(id)), LaneState::waiting_memory, LaneState::waiting_any_hit);
}

void FastRtUnit::any_hit_returns(Cycle now) {
  const AnyHitDone* done = links_.shader_dones->front(now);
  if (done == nullptr) return;
  unsigned entry = 0;
  while ((occupied_ >> entry & 1) == 0 || warps_[entry].slot != done->slot) ++entry;
  for_each_bit(done->lanes, [&](unsigned i) { complete(now, lane_id(entry, i), 0, LaneState::in_any_hit); });
  const Warp& warp = warps_[entry];
  if (warp.in_state(LaneState::in_any_hit) == 0 && warp.in_state(LaneState::waiting_any_hit) != 0) {
    candidates_ |= bit(entry);
  }
  links_.shader_dones->pop(now);
}

Cycle FastRtUnit::any_hit_due(const Warp& warp) const {
  return warp.in_state(LaneState::waiting_any_hit) == warp.active() ? 0 : warp.any_hit_since + config_.any_hit.timeout;
}

void FastRtUnit::fire(Cycle now) {
  if (candidates_ == 0) return;
  LaneMask eligible = 0;
  for_each_bit(candidates_, [&](unsigned e) {
    if (any_hit_due(warps_[e]) <= now) eligible |= bit(e);
  });
  if (eligible == 0 || !links_.batches->can_push(now)) return;
  const unsigned entry = oldest(eligible);
  const Warp& warp = warps_[entry];
  const AnyHitBatch batch = batch_of(warp);
  ++any_hit_counters_.batches;
  any_hit_counters_.lanes += static_cast<unsigned>(std::popcount(batch.lanes));
  if (batch.lanes != warp.active()) ++any_hit_counters_.timeouts;
  any_hit_counters_.wait_cycles += now - warp.any_hit_since;
  links_.batches->push(now, batch);
  move(now, entry, batch.lanes, LaneState::waiting_any_hit, LaneState::in_any_hit);
  candidates_ &= ~bit(entry);
}

void FastRtUnit::retire(Cycle now) {
  if (done_ == 0 || !links_.dones->can_push(now)) return;
  const unsigned entry = oldest(done_);
  Warp& warp = warps_[entry];
  links_.dones->push(now, {warp.slot, warp.round});
  count_wait(now + 1, entry);
  occupied_ &= ~bit(entry);
  done_ &= ~bit(entry);
  ready_ &= ~bit(entry);
  buffer_counters_.occupancy_integral += now - warp.accepted;
  buffer_counters_.warp_latency.add(now - warp.accepted);
  warp.group = nullptr;
}

void FastRtUnit::accept(Cycle now) {
  if (occupied_ == all_) return;
  const TraceCall* front = links_.calls->front(now);
  if (front == nullptr) return;
  const TraceCall call = *front;
  links_.calls->pop(now);
  const auto entry = static_cast<unsigned>(std::countr_zero(~occupied_));
  if (call.slot >= cursors_.size()) cursors_.resize(call.slot + std::size_t{1});
  RoundCursor& cursor = cursors_[call.slot];
  cursor.seek(*call.group, call.round);
  Warp& w = warps_[entry];
  begin_call(w, call, cursor, now);
  w.age = ages_[entry] = next_age_++;
  for_each_bit(call.lanes, [&](unsigned i) {
    const LaneId id = lane_id(entry, i);
    if (checkpoint_) {
      std::uint32_t entries = 0;
      if (checkpoint_->reads_backwards() && (w.replaying & bit(i)) != 0) {
        const auto events = cursor.events(i);
        entries = static_cast<std::uint32_t>(std::count_if(events.begin(), events.end(), [](const Event& e) {
          return e.kind() == EventKind::replay_take || e.kind() == EventKind::replay_forward;
        }));
      }
      checkpoint_->begin_lane(id, w.slot, w.round, entries);
    }
    if (prefetcher_) prefetcher_->begin_lane(id);
  });
  const LaneMask b = bit(entry);
  occupied_ |= b;
  if (w.in_state(LaneState::ready) != 0) ready_ |= b;
  if (w.in_state(LaneState::finished) == w.lanes) done_ |= b;
  times_[entry] = {now + 1, w.wait()};
  ++buffer_counters_.calls;
}

Cycle FastRtUnit::next_due(Cycle now) const {
  if (done_ != 0) return now + 1;
  Cycle due = std::min(links_.shader_dones->next_visible(), results_.next());
  if (ready_ != 0 && has_room()) return now + 1;
  if (!queue_.empty()) due = std::min(due, ask_.due());
  if (prefetching_ || (prefetcher_ && prefetcher_->busy())) due = std::min(due, prefetch_.due());
  if (occupied_ != all_) due = std::min(due, links_.calls->next_visible());
  for_each_bit(candidates_, [&](unsigned e) { due = std::min(due, any_hit_due(warps_[e])); });
  if (checkpoint_) {
    due = std::min(due, links_.checkpoint_responses->next_visible());
    if (checkpoint_->lanes_submitting() != 0) due = now + 1;
    if (checkpoint_->busy() && links_.checkpoint_requests->can_push(now + 1)) due = now + 1;
  }
  return std::max(due, now + 1);
}

bool FastRtUnit::idle() const {
  return occupied_ == 0 && queue_.empty() && results_.empty() && (!checkpoint_ || checkpoint_->idle()) &&
         !prefetching_ && (!prefetcher_ || prefetcher_->idle());
}

void FastRtUnit::settle(Cycle end) {
  if (end <= accounted_) return;
  scheduler_counters_.stall[static_cast<std::size_t>(stall_reason())] += end - accounted_;
  accounted_ = end;
}

RtUnitCounters FastRtUnit::counters() const {
  RtUnitCounters c;
  c.units = 1;
  c.warp_buffer = buffer_counters_;
  c.scheduler = scheduler_counters_;
  c.memory = memory_counters_;
  c.ray_box = box_.counters;
  (traffic_.leaf_kind() == NodeKind::triangle ? c.ray_triangle : c.ray_sphere) = leaf_.counters;
  c.ray_transform = transform_.counters;
  c.any_hit = any_hit_counters_;
  if (checkpoint_) c.checkpoint = checkpoint_->counters();
  if (prefetcher_) c.prefetch = prefetcher_->counters();
  return c;
}

}  // namespace grtx::tlm
