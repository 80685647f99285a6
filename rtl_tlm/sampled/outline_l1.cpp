// L1 of the outline model: its four clients take turns, and a request learns at once when it is answered.
#include "rtl_tlm/sampled/outline_machine.h"

namespace grtx::tlm::outline {

using namespace modules;

void Machine::serve(Cycle now, unsigned s) {
  Sm& sm = *sms_[s];
  for (bool progress = true; progress;) {
    progress = false;
    for (unsigned i = 0, c = sm.first; i < kClients; ++i, c = (c + 1) % kClients) {
      Port& port = sm.ports[c];
      while (!port.queue.empty() && port.until <= now && port.next <= now + kAhead) {
        const Taken taken = try_head(now, s, sm, c);
        if (taken == Taken::refused) break;
        if (taken == Taken::hit) continue;
        sm.first = (c + 1) % kClients;  // the others may send a miss first
        progress = true;
        break;
      }
    }
  }
  if (sm.ready != 0) select_soon(now, s);
  if (sm.port_timed) return;
  Cycle due = kNever;
  for (const Port& port : sm.ports) {
    if (port.queue.empty()) continue;
    due = std::min(due, std::max(port.until, port.next > kAhead / 2 ? port.next - kAhead / 2 : 0));
  }
  if (due == kNever) return;
  sm.port_timed = true;
  wheel_.add(due, ports_from_ + s);
}

Taken Machine::try_head(Cycle now, unsigned s, Sm& sm, unsigned client) {
  Port& port = sm.ports[client];
  const Request r = port.queue.front();
  Cycle at = std::max({port.next, now + 1, client == kNode ? sm.hits.room() : 0});
  const auto count = static_cast<unsigned>(std::popcount(r.sectors));
  Taken taken = Taken::hit;
  Cycle seen = 0;
  if (!config_.l1.perfect) {
    SectorCacheTags::Slot slot = sm.tags.find(r.line);
    const std::uint8_t valid = slot == SectorCacheTags::kNone ? std::uint8_t{0} : sm.tags.valid(slot);
    const auto missing = static_cast<std::uint8_t>(r.write ? r.sectors : r.sectors & ~valid);
    if (missing != 0) {
      const Cycle crossing = sm.crossed.room();
      Cycle room = crossing > config_.l1.tag_latency ? crossing - config_.l1.tag_latency : 0;
      if (!r.write) room = std::max(room, sm.mshrs.room());
      at = std::max(at, room);
      if (at > now + kAhead) {
        port.until = at - kAhead / 2;
        return Taken::refused;
      }
    }
    seen = at + count - 1 + config_.l1.latency;
    if (slot != SectorCacheTags::kNone) sm.tags.touch(slot);
    if (!r.write) {
      if (valid != 0 && sm.line_arrives[slot] > at)
        for (std::uint8_t rest = r.sectors & valid; rest != 0; rest &= static_cast<std::uint8_t>(rest - 1)) {
          seen = std::max(seen, sm.arrives[slot * sm.sectors + static_cast<unsigned>(std::countr_zero(rest))] + 1);
        }
      result_.l1_reads += count;
      result_.l1_hits += static_cast<unsigned>(std::popcount(static_cast<std::uint8_t>(r.sectors & valid)));
    }
    if (missing != 0) {
      taken = Taken::miss;
      const OutlineMemory::Trip trip = memory_.access(s, r.line, missing, r.write, at + config_.l1.tag_latency);
      const auto sent = static_cast<unsigned>(std::popcount(missing));
      for (unsigned i = 0; i < sent; ++i) sm.crossed.take(trip.crossed);
      seen = std::max(seen, trip.seen + 1);
      if (!r.write) {
        if (slot == SectorCacheTags::kNone) {
          SectorCacheTags::Victim victim;
          slot = sm.tags.insert(r.line, &victim);
        }
        sm.tags.set_valid(slot, missing);
        sm.line_arrives[slot] = std::max(sm.line_arrives[slot], trip.seen);
        for (std::uint8_t rest = missing; rest != 0; rest &= static_cast<std::uint8_t>(rest - 1)) {
          sm.arrives[slot * sm.sectors + static_cast<unsigned>(std::countr_zero(rest))] = trip.seen;
        }
        for (unsigned i = 0; i < sent; ++i) sm.mshrs.take(trip.seen);
      }
    }
  }
  if (config_.l1.perfect) seen = at + count - 1 + config_.l1.latency;
  port.next = at + count;
  port.queue.pop();
  if (client == kNode) {
    const bool in_pipeline = seen == at + count - 1 + config_.l1.latency;
    for (unsigned i = count; i > 0; --i) {
      const Cycle response = sm.responses.reserve(seen - (i - 1));
      if (in_pipeline) sm.hits.take(response);
      if (i == 1) seen = response;
    }
  } else if (sm.ports[kNode].next > at) {
    // Half of the conflicts about a bank are lost by the node request.
    sm.conflicts += count;
    if (sm.conflicts >= 2 * config_.l1.banks) {
      sm.conflicts -= 2 * config_.l1.banks;
      ++sm.ports[kNode].next;
    }
  }
  deliver(s, sm, client, r, seen);
  return taken;
}

void Machine::deliver(unsigned s, Sm& sm, unsigned client, const Request& r, Cycle seen) {
  switch (client) {
    case kNode: {
      Lane& lane = lanes_[r.owner];
      lane.seen = std::max(lane.seen, seen);
      if (!r.last) return;
      --sm.fetches;
      const Cycle ready = lane.seen;
      lane.seen = 0;
      if (r.place == kNoPlace) return await(r.owner, lane, ready);
      Fetch& f = sm.calls[lane.entry].fetches[r.place];
      f.ready = ready;
      for_each_bit(f.lanes, [&](unsigned i) {
        const Number number = lane_number(s, lane.entry, i);
        await(number, lanes_[number], ready);
      });
      f.lanes = 0;
      return;
    }
    case kCheckpoint: {
      if (r.write) return;
      Lane& lane = lanes_[r.owner];
      lane.seen = std::max(lane.seen, seen);
      if (r.last) wheel_.add(lane.seen, r.owner);
      return;
    }
    case kSimt: {
      Warp& warp = sm.warps[r.owner - warps_from_ - s * config_.resident_warps];
      if (r.write) {
        warp.stores_seen = std::max(warp.stores_seen, seen);
        if (--warp.stores_pending == 0 && warp.step == Step::draining) wheel_.add(warp.stores_seen, r.owner);
        return;
      }
      warp.loads_seen = std::max(warp.loads_seen, seen);
      if (--warp.loads_pending > 0) return;
      wheel_.add(warp.loads_seen + 1 + warp.instructions + config_.simt.instruction_latency, r.owner);
      return;
    }
    default:
      return;
  }
}

}  // namespace grtx::tlm::outline
