// RT unit of the outline model: calls, the order of warps, node fetches and their merging, sibling prefetches.
#include <fmt/format.h>

#include "base/error.h"
#include "rtl_tlm/sampled/outline_machine.h"

namespace grtx::tlm::outline {

using namespace modules;

void Machine::accept(Cycle now, unsigned s) {
  Sm& sm = *sms_[s];
  while (sm.free_entries != 0 && !sm.waiting_calls.empty()) {
    const unsigned slot = sm.waiting_calls.front();
    sm.waiting_calls.pop();
    const auto entry = static_cast<unsigned>(std::countr_zero(sm.free_entries));
    sm.free_entries &= sm.free_entries - 1;
    Warp& warp = sm.warps[slot];
    warp.entry = entry;
    const std::uint32_t round = sm.program.round(slot);
    warp.cursor.seek(warp.group, round);
    Call& call = sm.calls[entry];
    call.slot = static_cast<std::uint16_t>(slot);
    call.active = call.ready = call.waiting = call.in_shader = 0;
    for (Fetch& f : call.fetches) f = {};
    for_each_bit(sm.program.active_lanes(slot), [&](unsigned i) {
      const auto events = warp.cursor.events(i);
      if (events.empty()) return;
      const Number number = lane_number(s, entry, i);
      Lane& lane = lanes_[number];
      lane.next = events.data();
      lane.end = events.data() + events.size();
      call.active |= bit(i);
      call.ready |= bit(i);
      if (!records_.empty()) {
        std::fill_n(records_of(number), config_.rt.prefetcher.records, Record{});
        newest_[number] = 0;
      }
      if (header_.checkpoint) begin_checkpoints(s, slot, i, round, number, warp.cursor.round(i).replay);
    });
    sm.ages[entry] = next_age_++;
    if (call.ready != 0) {
      sm.ready |= bit(entry);
      select_soon(now, s);
    } else {
      retire(now, s, entry);
    }
  }
}

void Machine::retire(Cycle now, unsigned s, unsigned entry) {
  Sm& sm = *sms_[s];
  sm.free_entries |= bit(entry);
  const unsigned slot = sm.calls[entry].slot;
  wheel_.add(now + 1 + config_.sm_links.message_latency, warps_from_ + s * config_.resident_warps + slot);
  if (!sm.waiting_calls.empty()) accept(now + 1, s);
}

/// The next event of the lane waits for its warp's turn.
void Machine::make_ready(Cycle now, Number number, const Lane& lane) {
  Sm& sm = *sms_[lane.sm];
  sm.calls[lane.entry].ready |= bit(number % kMaxLanes);
  sm.ready |= bit(lane.entry);
  select_soon(now, lane.sm);
}

void Machine::select_soon(Cycle now, unsigned s) {
  Sm& sm = *sms_[s];
  if (sm.select_timed || !has_room(sm)) return;
  sm.select_timed = true;
  wheel_.add(now + 1, selects_from_ + s);
}

/// One warp a cycle: all its lanes that are ready.
void Machine::select(Cycle now, unsigned s) {
  Sm& sm = *sms_[s];
  sm.select_timed = false;
  if (sm.ready == 0 || !has_room(sm)) return;
  const unsigned entry = selection_->select(sm.ready, sm.ages);
  const LaneMask lanes = sm.calls[entry].ready;
  sm.calls[entry].ready = 0;
  sm.ready &= ~bit(entry);
  const bool idle = sm.ports[kNode].queue.empty();
  if (idle) sm.ports[kNode].next = std::max(sm.ports[kNode].next, now + 2);
  for_each_bit(lanes, [&](unsigned i) {
    const Number number = lane_number(s, entry, i);
    handle(now, number, lanes_[number]);
  });
  if (idle) serve(now, s);
  if (sm.ready != 0) select_soon(now, s);
}

void Machine::handle(Cycle now, Number number, Lane& lane) {
  const Event event = *lane.next;
  switch (event.kind()) {
    case EventKind::visit_internal: {
      const auto& node = group_of(lane).nodes[event.node];
      fetch(now, number, lane, NodeKind::internal, std::uint64_t{node.address} * traces::kNodeUnit, false);
      return;
    }
    case EventKind::visit_instance:
      fetch(now, number, lane, NodeKind::instance, std::uint64_t{event.node} * traces::kNodeUnit,
            event.detail == 0 && traffic_.header_read());
      if (!records_.empty()) note_leaf(number, lane, event.node);
      return;
    case EventKind::visit_leaf:
      fetch(now, number, lane, traffic_.leaf_kind(), std::uint64_t{event.node} * traces::kNodeUnit, false);
      if (!records_.empty()) note_leaf(number, lane, event.node);
      return;
    case EventKind::cull:
      advance(now, number, lane, event.checkpoints);
      return;
    default:
      if (!header_.checkpoint) {
        const Call& call = sms_[lane.sm]->calls[lane.entry];
        throw Error("trace",
                    fmt::format("group {} lane {} round {}", group_of(lane).index, number % kMaxLanes,
                                sms_[lane.sm]->program.round(call.slot)),
                    "replays although checkpointing is off");
      }
      if (read_checkpoint(now, number)) advance(now, number, lane, event.checkpoints);
  }
}

void Machine::advance(Cycle now, Number number, Lane& lane, unsigned checkpoints) {
  ++lane.next;
  const bool last = lane.next == lane.end;
  if (header_.checkpoint) write_checkpoints(now, number, checkpoints, last);
  if (!last) return make_ready(now, number, lane);
  Call& call = sms_[lane.sm]->calls[lane.entry];
  call.active &= ~bit(number % kMaxLanes);
  if (call.active == 0) {
    retire(now, lane.sm, lane.entry);
  } else if (call.waiting != 0) {
    consider_any_hit(now, lane.sm, lane.entry);
  }
}

void Machine::tested(Cycle now, Number number, Lane& lane) {
  const Event event = *lane.next;
  unsigned checkpoints = 0;
  switch (event.kind()) {
    case EventKind::visit_internal:
      checkpoints = static_cast<unsigned>(std::popcount(unsigned{event.checkpoints}));
      if (!records_.empty() && (event.pushed() & (event.pushed() - 1)) != 0) note_internal(number, lane, event);
      break;
    case EventKind::visit_leaf: {
      Call& call = sms_[lane.sm]->calls[lane.entry];
      const LaneMask b = bit(number % kMaxLanes);
      if (traces::calls_any_hit(event.outcome()) && (call.in_shader & b) == 0 && !returned(lane)) {
        if (call.waiting == 0) call.since = now;
        call.waiting |= b;
        returned_from_shader(lane, true);
        consider_any_hit(now, lane.sm, lane.entry);
        return;
      }
      returned_from_shader(lane, false);
      checkpoints = event.checkpoints;
      break;
    }
    case EventKind::visit_instance:
      break;
    default:  // replays whose entry has come
      checkpoints = event.kind() == EventKind::replay_forward ? event.checkpoints : 0;
  }
  advance(now, number, lane, checkpoints);
}

void Machine::fetch(Cycle now, Number number, Lane& lane, NodeKind kind, std::uint64_t address, bool header) {
  Sm& sm = *sms_[lane.sm];
  Call& call = sm.calls[lane.entry];
  lane.seen = 0;
  if (lane.next + 1 != lane.end && lane.next[1].kind() == EventKind::visit_internal) {
    prefetch_for_read(&group_of(lane).nodes[lane.next[1].node]);
  }
  const std::uint64_t key = address / kSectorBytes << 1 | (header ? 1u : 0u);
  const auto home = static_cast<unsigned>((key * 0x9E3779B97F4A7C15u) >> 58);
  auto place = static_cast<std::uint8_t>(home);
  bool found = false;
  for (unsigned i = 0; !found && i < kProbes; ++i) {
    const auto probe = static_cast<std::uint8_t>((home + i) % kPlaces);
    const Fetch& g = call.fetches[probe];
    found = g.key == key && g.ready > now;
    if (found || g.ready < call.fetches[place].ready) place = probe;
  }
  Fetch& f = call.fetches[place];
  if (found) {
    if (f.ready == kNever) {
      f.lanes |= bit(number % kMaxLanes);
    } else {
      await(number, lane, f.ready);
    }
    return;
  }
  if (f.ready == kNever) {
    place = kNoPlace;
  } else {
    f = {key, kNever, bit(number % kMaxLanes)};
  }
  ++sm.fetches;
  push_node(sm, kNode, number, address, traffic_.sectors(kind), place, !header);
  if (header) {
    push_node(sm, kNode, number, traffic_.blas_header(), static_cast<unsigned>(traces::kHeaderBytes / kSectorBytes),
              place, true);
  }
}

void Machine::push_node(Sm& sm, Client client, Number owner, std::uint64_t address, unsigned sectors,
                        std::uint8_t place, bool last) {
  while (sectors > 0) {
    const std::uint64_t line = sm.tags.line_address(address);
    std::uint8_t mask = 0;
    for (; sectors > 0 && sm.tags.line_address(address) == line; --sectors, address += kSectorBytes) {
      mask |= sm.tags.sector_bit(address);
    }
    sm.ports[client].queue.push({line, owner, mask, place, false, last && sectors == 0});
  }
}

/// The node is there in cycle `ready`.
void Machine::await(Number number, const Lane& lane, Cycle ready) {
  const EventKind kind = lane.next->kind();
  if (lane.next + 1 != lane.end) {
    const Event& following = lane.next[1];
    if (following.kind() == EventKind::visit_internal) {
      prefetch_host(*sms_[lane.sm], std::uint64_t{group_of(lane).nodes[following.node].address} * traces::kNodeUnit);
    } else {
      prefetch_host(*sms_[lane.sm], std::uint64_t{following.node} * traces::kNodeUnit);
    }
  }
  const Cycle latency = kind == EventKind::visit_internal   ? config_.rt.ray_box.latency
                        : kind == EventKind::visit_instance ? config_.rt.ray_transform.latency
                                                            : leaf_latency_;
  wheel_.add(ready + latency, number);
}

void Machine::note_internal(Number number, const Lane& lane, const Event& event) {
  const traces::NodeDefinition& node = group_of(lane).nodes[event.node];
  bool has_leaf = false;
  std::uint32_t end = node.child_base;
  for (unsigned i = 0; i < node.child_count; ++i) {
    end += units_[static_cast<std::size_t>(node.child_kinds[i])];
    has_leaf = has_leaf || ((event.pushed() >> i & 1) != 0 && node.child_kinds[i] != NodeKind::internal);
  }
  if (!has_leaf) return;
  std::uint8_t& newest = newest_[number];
  newest = newest + 1u == config_.rt.prefetcher.records ? std::uint8_t{0} : static_cast<std::uint8_t>(newest + 1);
  records_of(number)[newest] = {node.child_base, end, event.node, static_cast<std::uint8_t>(event.pushed()), true};
}

void Machine::note_leaf(Number number, const Lane& lane, std::uint32_t address) {
  Record* const records = records_of(number);
  unsigned at = newest_[number];
  for (unsigned back = 0; back < config_.rt.prefetcher.records; ++back) {
    Record& record = records[at];
    at = at == 0 ? config_.rt.prefetcher.records - 1 : at - 1;
    if (record.hit == 0) return;
    if (address < record.begin || address >= record.end) continue;
    if (!record.armed) return;
    record.armed = false;
    const traces::NodeDefinition& node = group_of(lane).nodes[record.definition];
    Sm& sm = *sms_[lane.sm];
    RingQueue<Request>& queue = sm.ports[kPrefetch].queue;
    const bool idle = queue.empty();
    std::uint32_t child = node.child_base;
    for (unsigned i = 0; i < node.child_count; ++i) {
      const NodeKind kind = node.child_kinds[i];
      if ((record.hit >> i & 1) != 0 && child != address && queue.size() < config_.rt.prefetcher.queue) {
        push_node(sm, kPrefetch, 0, std::uint64_t{child} * traces::kNodeUnit, traffic_.sectors(kind), kNoPlace, true);
        prefetch_host(sm, std::uint64_t{child} * traces::kNodeUnit);
      }
      child += units_[static_cast<std::size_t>(kind)];
    }
    if (idle) serve(wheel_.now(), lane.sm);
    return;
  }
}

}  // namespace grtx::tlm::outline
