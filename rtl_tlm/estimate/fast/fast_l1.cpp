// The L1 in fast mode: its four clients take turns, and a request learns at once when it is answered. What is on its
// way stands beside the tags, with the cycle of its arrival, and takes its place in them when it has come.
#include <algorithm>
#include <bit>
#include <utility>

#include "grtx/rtl_tlm/estimate/fast/fast_machine.h"

namespace grtx::sim::fast {

using namespace modules;

namespace {

constexpr unsigned kAllPorts = (1u << kClients) - 1;

unsigned count_of(unsigned sectors) { return static_cast<unsigned>(std::popcount(sectors)); }

}  // namespace

// Requests of a port until one is refused or a miss, or until they are too far ahead of time.
template <Client kClient>
bool Machine::serve_port(Cycle now, unsigned s, Sm& sm) {
  const Port& port = sm.ports[kClient];
  Taken taken = Taken::hit;
  while (taken == Taken::hit && !port.queue.empty() && port.until <= now && port.next <= now + kAhead) {
    taken = try_head<kClient>(now, s, sm);
  }
  if (port.queue.empty()) sm.waiting &= ~(1u << kClient);
  return taken == Taken::miss;
}

void Machine::serve(Cycle now, unsigned s) {
  Sm& sm = sms_[s];
  for (bool progress = true; progress;) {
    progress = false;
    const unsigned first = sm.first;
    // The ports with requests, from that whose turn it is on.
    for (unsigned rest = sm.waiting >> first | (sm.waiting << (kClients - first) & kAllPorts); rest != 0;
         rest &= rest - 1) {
      const unsigned c = (first + static_cast<unsigned>(std::countr_zero(rest))) % kClients;
      const bool miss = c == kNode         ? serve_port<kNode>(now, s, sm)
                        : c == kPrefetch   ? serve_port<kPrefetch>(now, s, sm)
                        : c == kCheckpoint ? serve_port<kCheckpoint>(now, s, sm)
                                           : serve_port<kSimt>(now, s, sm);
      if (!miss) continue;
      sm.first = (c + 1) % kClients;  // the others may send a miss first
      progress = true;
    }
  }
  if (sm.ready != 0) select_soon(now, s, sm);
  if (sm.port_timed) return;
  Cycle due = kNever;
  for (unsigned rest = sm.waiting; rest != 0; rest &= rest - 1) {
    const Port& port = sm.ports[static_cast<unsigned>(std::countr_zero(rest))];
    due = std::min(due, std::max(port.until, port.next > kAhead / 2 ? port.next - kAhead / 2 : 0));
  }
  if (due == kNever) return;
  sm.port_timed = true;
  wheel_.add(due, ports_from_ + s);
}

// Node requests are served ahead of time, so half of the time the others go first.
Cycle Machine::take_banks(Sm& sm, unsigned client, const Request& r, Cycle at) {
  const std::uint64_t first = r.line / kSectorBytes;
  const auto lowest = static_cast<unsigned>(std::countr_zero(r.sectors));
  const unsigned run = unsigned{r.sectors} >> lowest;
  const unsigned count = count_of(run);
  if ((run & (run + 1)) == 0) {
    const unsigned bank = sm.banks.bank(first + lowest);
    if (sm.banks.reserve_run(bank, at, count)) return at + count - 1;
    std::uint64_t& conflicts = sm.l1.stalls[static_cast<std::size_t>(L1Stall::bank_conflict)];
    // One of the two waits, once: their banks follow each other from then on.
    if (std::exchange(sm.between, !sm.between)) {
      ++conflicts;
      if (client != kNode) ++sm.ports[kNode].next;
      sm.banks.share_run(bank, at, count);
    } else {
      do {
        ++conflicts;
        ++at;
      } while (!sm.banks.reserve_run(bank, at, count));
    }
    return at + count - 1;
  }
  std::uint64_t conflicts = 0;
  --at;
  for (std::uint8_t rest = r.sectors; rest != 0; rest &= static_cast<std::uint8_t>(rest - 1)) {
    const std::uint64_t sector = first + static_cast<unsigned>(std::countr_zero(rest));
    ++at;
    const Cycle taken = sm.banks.reserve(sm.banks.bank(sector), at);
    if (taken == at) continue;
    if (std::exchange(sm.between, !sm.between)) {
      ++conflicts;  // of the other
      if (client != kNode) ++sm.ports[kNode].next;
    } else {
      conflicts += taken - at;
      at = taken;
    }
  }
  sm.l1.stalls[static_cast<std::size_t>(L1Stall::bank_conflict)] += conflicts;
  return at;
}

template <Client kClient>
Machine::Taken Machine::try_head(Cycle now, unsigned s, Sm& sm) {
  constexpr bool kWrites = kClient == kSimt || kClient == kCheckpoint;
  Port& port = sm.ports[kClient];
  const Request r = port.queue.front();
  const bool write = kWrites && r.write;
  if (r.owner == kNobody) {
    port.queue.pop();
    --port.timeless;
    warm_caches(s, sm, kClient, r.line, r.sectors, r.region, write);
    return Taken::hit;
  }
  Cycle at = std::max(port.next, now + 1);
  if (kClient == kNode) at = std::max(at, sm.hits.room());
  SectorCacheTags::Slot slot = SectorCacheTags::kNone;
  std::uint8_t present = r.sectors;
  std::uint8_t missing = 0;
  std::uint32_t filling = AddressIndex::kNone;
  if (!config_.l1.perfect) {
    slot = sm.tags.find(r.line);
    present = slot == SectorCacheTags::kNone ? std::uint8_t{0} : r.sectors & sm.tags.valid(slot);
    missing = write ? r.sectors : r.sectors ^ present;
  }
  std::uint8_t on_the_way = 0;
  if (missing != 0) {
    if (!write) {
      filling = sm.filling.find(r.line / kSectorBytes);
      if (filling != AddressIndex::kNone) on_the_way = missing & sm.fills[filling].sectors;
      missing ^= on_the_way;
    }
    if (missing != 0) {
      const Cycle sends = sm.crossed.room();
      const Cycle holds = write ? 0 : sm.mshrs.room(at);
      const L1Stall reason = std::max(sends, holds) <= at ? L1Stall::response_port
                             : holds > sends              ? L1Stall::mshr_full
                                                          : L1Stall::miss_queue_full;
      at = std::max({at, sends, holds});
      if (at > now + kAhead) {
        port.until = at - kAhead / 2;
        sm.l1.stalls[static_cast<std::size_t>(reason)] += port.until - now;
        return Taken::refused;
      }
    }
  }
  const unsigned count = count_of(r.sectors);
  Cycle taken = take_banks(sm, kClient, r, at);
  if (missing != 0) taken = std::max(taken, sm.crossed.room(count_of(missing)));
  const Cycle through = taken + config_.l1.latency;
  Cycle seen = present != 0 && (!write || config_.l1.perfect) ? through : 0;
  port.next = taken + 1 + (one_by_one_ ? count : 0);
  port.queue.pop();
  if (on_the_way != 0) {
    Cycle last = 0;
    const std::uint8_t awaited = sm.fills[filling].awaited(on_the_way, at, last);
    if (awaited != on_the_way) seen = std::max(seen, through);
    if (awaited != 0) seen = std::max(seen, last + 1);
    present |= on_the_way ^ awaited;
    on_the_way = awaited;
  }
  count_access<kClient>(sm, slot, r, present, on_the_way, filling);
  if (slot != SectorCacheTags::kNone) sm.tags.touch(slot);
  if (missing != 0) seen = std::max(seen, send_miss(s, sm, filling, r, missing, kClient == kPrefetch, at));
  if (kClient == kNode) {
    sm.link_pushed = sm.link.take_in_turn(taken, count) + 1;
    const bool in_pipeline = seen == through;
    if (sm.responses.reserve_run(seen, count, in_pipeline)) {
      if (in_pipeline) sm.hits.take_in_turn(seen, count);
    } else {
      const Cycle first = seen - (count - 1);
      for (unsigned i = 0; i < count; ++i) {
        seen = in_pipeline ? sm.responses.reserve_hit(first + i) : sm.responses.reserve_fill(first + i);
        if (in_pipeline) sm.hits.take(seen);
      }
    }
  }
  deliver<kClient>(s, sm, r, seen);
  return missing != 0 ? Taken::miss : Taken::hit;
}

template <Client kClient>
void Machine::count_access(Sm& sm, SectorCacheTags::Slot slot, const Request& r, std::uint8_t present,
                           std::uint8_t on_the_way, std::uint32_t filling) {
  L1Counters& l1 = sm.l1;
  RegionCounters& region = l1.region[static_cast<std::size_t>(r.region)];
  const unsigned count = count_of(r.sectors), hits = count_of(present), awaited = count_of(on_the_way);
  l1.responses += count;
  if (kClient == kPrefetch) {
    l1.prefetches += count;
    l1.prefetches_redundant += hits + awaited;
    return;
  }
  if ((kClient == kSimt || kClient == kCheckpoint) && r.write) {
    region.writes += count;
    region.write_hits += hits;
  } else {
    region.reads += count;
    region.hits += hits;
    region.hits_on_miss += awaited;
    region.misses += count - hits - awaited;
  }
  if (slot != SectorCacheTags::kNone) demand(sm, slot, present);
  if (filling != AddressIndex::kNone) demand(sm, sm.fills[filling], present | on_the_way, on_the_way);
}

void Machine::demand(Sm& sm, SectorCacheTags::Slot slot, std::uint8_t sectors) {
  const auto first = static_cast<std::uint8_t>(sm.tags.unused_prefetch(slot) & sectors);
  if (first == 0) return;
  sm.l1.prefetches_useful += count_of(first);
  sm.tags.clear_unused_prefetch(slot, first);
}

void Machine::demand(Sm& sm, Fill& fill, std::uint8_t sectors, std::uint8_t awaited) {
  sm.l1.prefetches_useful += count_of(fill.prefetched & sectors & ~awaited);
  sm.l1.prefetches_late += count_of(fill.prefetched & awaited);
  fill.prefetched &= static_cast<std::uint8_t>(~sectors);
}

// Returns when the answer can be seen.
Cycle Machine::send_miss(unsigned s, Sm& sm, std::uint32_t filling, const Request& r, std::uint8_t missing,
                         bool prefetched, Cycle at) {
  const unsigned count = count_of(missing);
  const FastMemory::Trip trip = memory_.access({s, r.line, missing, r.region, r.write}, at + config_.l1.tag_latency);
  sm.crossed.take(trip.crossed, count);
  if (r.write) {
    sm.l1.sent_writes += count;
    return trip.seen + 1;
  }
  sm.l1.sent_reads += count;
  sm.l1.mshr_cycles += count * (trip.seen - at);
  sm.l1.miss_latency.add(trip.seen - at, count);
  sm.mshrs.take(trip.seen, count);
  if (prefetched) sm.l1.prefetches_fetched += count;
  if (filling == AddressIndex::kNone) {
    if (sm.free_fills.empty()) {  // a memory so slow that the MSHRs' calendar ends before it answers
      const SectorCacheTags::Slot slot = place(sm, r.line, missing, true);
      if (prefetched) sm.tags.set_unused_prefetch(slot, missing);
      return trip.seen + 1;
    }
    filling = sm.free_fills.back();
    sm.free_fills.pop_back();
    sm.filling.insert(r.line / kSectorBytes, filling);
    sm.fills[filling].line = r.line;
    sm.fills[filling].sectors = sm.fills[filling].prefetched = 0;
    wheel_.add(trip.seen, fills_from_ + s * fills_ + filling);
  }
  Fill& fill = sm.fills[filling];
  fill.sectors |= missing;
  if (prefetched) fill.prefetched |= missing;
  fill.complete = fill.sectors == missing ? trip.seen : std::max(fill.complete, trip.seen);
  for (std::uint8_t rest = missing; rest != 0; rest &= static_cast<std::uint8_t>(rest - 1)) {
    fill.arrives[static_cast<unsigned>(std::countr_zero(rest))] = NearCycle(trip.seen);
  }
  return trip.seen + 1;
}

// All sectors that were on their way when the first came take their place together.
void Machine::fill(Cycle now, unsigned s, std::uint32_t number) {
  Sm& sm = sms_[s];
  const Fill& fill = sm.fills[number];
  if (fill.complete > now) return wheel_.add(fill.complete, fills_from_ + s * fills_ + number);
  const SectorCacheTags::Slot slot = place(sm, fill.line, fill.sectors, true);
  if (fill.prefetched != 0) sm.tags.set_unused_prefetch(slot, fill.prefetched);
  sm.filling.erase(fill.line / kSectorBytes);
  sm.free_fills.push_back(number);
}

SectorCacheTags::Slot Machine::place(Sm& sm, std::uint64_t line, std::uint8_t sectors, bool timed) {
  SectorCacheTags::Slot slot = sm.tags.find(line);
  if (slot == SectorCacheTags::kNone) {
    SectorCacheTags::Victim victim;
    slot = sm.tags.insert(line, &victim);
    if (victim.valid && timed) ++sm.l1.evictions;
    sm.l1.prefetches_unused += count_of(victim.unused_prefetch);
  }
  if (timed) sm.l1.fills += count_of(sectors);
  sm.tags.set_valid(slot, sectors);
  return slot;
}

template <Client kClient>
void Machine::deliver(unsigned s, Sm& sm, const Request& r, Cycle seen) {
  if constexpr (kClient == kNode) {
    const unsigned entry = lanes_[r.owner].entry;
    Fetches& fetches = sm.calls[entry].fetches;
    const unsigned leader = r.owner % kMaxLanes;
    const Cycle ready = std::max(fetches.ready[leader].at(seen), seen);
    fetches.ready[leader] = NearCycle(ready);
    if (!r.last) return;
    --sm.fetches;
    sm.leaving.push(sm.link_pushed);
    sm.rt.memory.fetch_latency.add(ready - fetches.asked[leader].at(ready));
    for_each_bit(std::exchange(fetches.lanes[leader], 0u), [&](unsigned i) {
      const Number number = lane_number(s, entry, i);
      await(sm, number, lanes_[number], ready);
    });
  } else if constexpr (kClient == kCheckpoint) {
    if (r.write) {
      ++sm.rt.checkpoint.acknowledged;
      return;
    }
    ++sm.rt.checkpoint.returned;
    Checkpoints& c = checkpoints_[r.owner];
    c.seen = std::max(c.seen, seen);
    if (r.last) wheel_.add(c.seen, r.owner);
  } else if constexpr (kClient == kSimt) {
    Warp& warp = sm.warps[r.owner - warp_number(s, 0)];
    if (r.write) {
      warp.stores_seen = std::max(warp.stores_seen, seen);
      if (--warp.stores_pending == 0 && warp.step == Step::draining) wheel_.add(warp.stores_seen, r.owner);
      return;
    }
    warp.loads_seen = std::max(warp.loads_seen, seen);
    if (--warp.loads_pending == 0) wheel_.add(loaded(warp, warp.loads_seen), r.owner);
  }
}

}  // namespace grtx::sim::fast
