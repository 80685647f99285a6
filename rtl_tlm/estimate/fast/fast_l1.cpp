#include "grtx/rtl_tlm/estimate/fast/fast_l1.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "grtx/rtl_tlm/estimate/fast/fast_rt_unit.h"
#include "grtx/rtl_tlm/estimate/fast/fast_simt.h"

namespace grtx::sim::fast {

using namespace modules;

namespace {

constexpr unsigned kAllPorts = (1u << kClients) - 1;

unsigned count_of(unsigned sectors) { return static_cast<unsigned>(std::popcount(sectors)); }

}  // namespace

// An MSHR holds a sector; they are reserved in turn, so a few more lines than that may be on their way.
std::size_t L1::fills_of(const GpuConfig& config) { return std::size_t{2} * config.l1.mshr_entries + 64; }

L1::L1(Shared& shared, unsigned sm)
    : shared_(shared),
      config_(shared.config.l1),
      sm_(sm),
      one_by_one_(shared.config.sm_links.l1_capacity == 1),
      tags_(config_.geometry),
      written_by_(config_.private_writes.policy == WritePolicy::write_back ? tags_.slots() : 0),
      sectors_(config_.geometry.sectors()),
      largest_(std::max(1u, config_.mshr_entries / 8)),  // a request waits for one MSHR and takes one a sector
      fills_(fills_of(shared.config)),
      filling_(fills_.size()),
      link_(shared.config.sm_links.l1_capacity * shared.config.rt.memory.sectors_per_cycle),
      crossed_(config_.miss_queue + shared.config.links.capacity),
      leaving_(config_.write_back_buffer),
      mshrs_(config_.mshr_entries),
      hits_(std::size_t{config_.latency} * shared.config.rt.memory.sectors_per_cycle),
      banks_(config_.banks) {
  for (auto i = static_cast<std::uint32_t>(fills_.size()); i > 0; --i) free_fills_.push_back(i - 1);
  ports_[kNode].width = shared.config.rt.memory.sectors_per_cycle;
  ports_[kSimt].width = shared.config.simt.sectors_per_cycle;
}

bool L1::waits(Client client, std::uint64_t address) const {
  const RingQueue<Request>& queue = ports_[client].queue;
  const std::uint64_t line = tags_.line_address(address);
  const std::uint8_t sector = tags_.sector_bit(address);
  for (std::size_t i = 0; i < queue.size(); ++i) {
    if (queue[i].line == line && (queue[i].sectors & sector) != 0 && queue[i].owner != kNobody) return true;
  }
  return false;
}

bool L1::idle() const {
  return std::all_of(ports_.begin(), ports_.end(), [](const Port& port) { return port.queue.empty(); });
}

L1Counters L1::counters() const {
  L1Counters counters = counters_;
  counters.prefetches_unused += tags_.count_unused_prefetch();
  return counters;
}

inline std::uint8_t L1::Fill::awaited(std::uint8_t wanted, Cycle now, Cycle& last) const {
  std::uint8_t late = 0;
  for (std::uint8_t rest = wanted; rest != 0; rest &= static_cast<std::uint8_t>(rest - 1)) {
    const auto sector = static_cast<unsigned>(std::countr_zero(rest));
    const Cycle at = arrives[sector].at(now);
    if (at <= now) continue;
    last = std::max(last, at);
    late |= static_cast<std::uint8_t>(1u << sector);
  }
  return late;
}

// Requests of a port until one is refused or a miss, or until they are too far ahead of time.
template <Client kClient>
bool L1::serve_port(Cycle now) {
  const Port& port = ports_[kClient];
  Taken taken = Taken::hit;
  while (taken == Taken::hit && !port.queue.empty() && port.until <= now && port.next <= now + kAhead) {
    taken = try_head<kClient>(now);
  }
  if (port.queue.empty()) waiting_ &= ~(1u << kClient);
  return taken == Taken::miss;
}

void L1::serve(Cycle now) {
  for (bool progress = true; progress;) {
    progress = false;
    const unsigned first = first_;
    // The ports with requests, from that whose turn it is on.
    for (unsigned rest = waiting_ >> first | (waiting_ << (kClients - first) & kAllPorts); rest != 0;
         rest &= rest - 1) {
      const unsigned c = (first + static_cast<unsigned>(std::countr_zero(rest))) % kClients;
      const bool miss = c == kNode         ? serve_port<kNode>(now)
                        : c == kPrefetch   ? serve_port<kPrefetch>(now)
                        : c == kCheckpoint ? serve_port<kCheckpoint>(now)
                        : c == kStack      ? serve_port<kStack>(now)
                                           : serve_port<kSimt>(now);
      if (!miss) continue;
      first_ = (c + 1) % kClients;  // the others may send a miss first
      progress = true;
    }
  }
  rt_->room_may_have_come(now);
  if (turn_timed_) return;
  Cycle due = kNever;
  for (unsigned rest = waiting_; rest != 0; rest &= rest - 1) {
    const Port& port = ports_[static_cast<unsigned>(std::countr_zero(rest))];
    due = std::min(due, std::max(port.until, port.next > kAhead / 2 ? port.next - kAhead / 2 : 0));
  }
  if (due == kNever) return;
  turn_timed_ = true;
  shared_.agenda.add(due, {What::l1_turn, sm_, 0});
}

// Node requests are served ahead of time, so half of the time the others go first. A wide port of nodes has requests in
// nearly every cycle: who comes now and then goes before the port that had the last one.
Cycle L1::take_banks(unsigned client, const Request& r, Cycle at) {
  const std::uint64_t first = r.line / kSectorBytes;
  const auto lowest = static_cast<unsigned>(std::countr_zero(r.sectors));
  const unsigned run = unsigned{r.sectors} >> lowest;
  const unsigned count = count_of(run);
  const unsigned width = ports_[client].width;
  if ((run & (run + 1)) == 0 && width == 1) {
    const unsigned bank = banks_.bank(first + lowest);
    if (banks_.reserve_run(bank, at, count)) return at + count - 1;
    std::uint64_t& conflicts = counters_.stalls[static_cast<std::size_t>(L1Stall::bank_conflict)];
    // One of the two waits, once: their banks follow each other from then on. A single bank follows none.
    if (config_.banks > 1 && std::exchange(between_, !between_)) {
      ++conflicts;
      if (client != kNode) ++ports_[kNode].next;
      banks_.share_run(bank, at, count);
    } else {
      do {
        ++conflicts;
        ++at;
      } while (!banks_.reserve_run(bank, at, count));
    }
    return at + count - 1;
  }
  std::uint64_t conflicts = 0;
  Port& port = ports_[client];
  const auto next_cycle = [&](Cycle cycle) {
    at = cycle;
    port.begin_cycle();
  };
  if (at != port.next) port.begin_cycle();
  for (std::uint8_t rest = r.sectors; rest != 0; rest &= static_cast<std::uint8_t>(rest - 1)) {
    const unsigned bank = banks_.bank(first + static_cast<unsigned>(std::countr_zero(rest)));
    const std::uint64_t bit = std::uint64_t{1} << bank;
    const bool own = port.used < width && (port.banks & bit) != 0;  // another of its sectors has the bank
    conflicts += own ? 1 : 0;
    if (own || port.used == width) next_cycle(at + 1);
    const Cycle taken = banks_.reserve(bank, at);
    if (taken != at) {
      const bool other = ports_[kNode].width > 1 ? (client == kNode) == (++conflict_ % kNodesWin == 0)
                                                 : std::exchange(between_, !between_);
      if (other) {
        ++conflicts;  // of the other
        if (client != kNode) ++ports_[kNode].next;
      } else {
        conflicts += taken - at;
        next_cycle(taken);
      }
    }
    ++port.used;
    port.banks |= bit;
  }
  counters_.stalls[static_cast<std::size_t>(L1Stall::bank_conflict)] += conflicts;
  return at;
}

template <Client kClient>
L1::Taken L1::try_head(Cycle now) {
  constexpr bool kWrites = kClient == kSimt || kClient == kCheckpoint || kClient == kStack;
  Port& port = ports_[kClient];
  Request r = port.queue.front();
  const bool write = kWrites && r.write;
  if (r.owner == kNobody) {
    port.queue.pop();
    --port.timeless;
    warm_caches(kClient, r.line, r.sectors, r.region, write);
    return Taken::hit;
  }
  Cycle at = std::max(port.next, now + 1);
  if (kClient == kNode) at = std::max(at, hits_.room());
  SectorCacheTags::Slot slot = SectorCacheTags::kNone;
  std::uint8_t present = r.sectors;
  std::uint8_t missing = 0;
  std::uint32_t filling = AddressIndex::kNone;
  PrivateWrites::Effect effect;
  if (!config_.perfect) {
    slot = tags_.find(r.line);
    present = slot == SectorCacheTags::kNone ? std::uint8_t{0} : r.sectors & tags_.valid(slot);
    if (write) effect = config_.private_writes.effect(r.region, slot != SectorCacheTags::kNone);
    missing = !write ? r.sectors ^ present : effect.forward ? r.sectors : std::uint8_t{0};
  }
  std::uint8_t on_the_way = 0;
  if (missing != 0) {
    if (!write) {
      filling = filling_.find(r.line / kSectorBytes);
      if (filling != AddressIndex::kNone) on_the_way = missing & fills_[filling].sectors;
      missing ^= on_the_way;
    }
  }
  const bool replaces = effect.keep && slot == SectorCacheTags::kNone;
  if (missing != 0 || replaces) {
    Cycle sends = missing != 0 ? crossed_.room() : 0;
    if (replaces && !victim_can_leave(r.line, at)) sends = std::max(sends, leaving_.room());
    const Cycle holds = write ? 0 : mshrs_.room(at);
    const L1Stall reason = std::max(sends, holds) <= at ? L1Stall::response_port
                           : holds > sends              ? L1Stall::mshr_full
                                                        : L1Stall::miss_queue_full;
    at = std::max({at, sends, holds});
    if (at > now + kAhead) {
      port.until = at - kAhead / 2;
      counters_.stalls[static_cast<std::size_t>(reason)] += port.until - now;
      return Taken::refused;
    }
  }
  // Where places in the miss queue are short, each sector that needs one waits for its turn.
  std::uint8_t later = 0;
  if (kClient == kNode && count_of(missing) > 1 && crossed_.room(count_of(missing)) > at) {
    const auto first = static_cast<std::uint8_t>(missing & -missing);
    later = static_cast<std::uint8_t>(r.sectors & ~(first | (first - 1)));
  }
  if (later != 0) {
    r.sectors ^= later;
    r.last = false;
    present &= r.sectors;
    on_the_way &= r.sectors;
    missing &= r.sectors;
  }
  const unsigned count = count_of(r.sectors);
  const Cycle banks = take_banks(kClient, r, at);
  Cycle taken = banks;
  if (missing != 0) taken = std::max(taken, crossed_.room(count_of(missing)));
  const Cycle through = taken + config_.latency;
  Cycle seen = present != 0 && (!write || config_.perfect) ? through : 0;
  if (effect.dirty) seen = through;
  if (port.width > 1 && port.used < port.width && taken == banks && !one_by_one_) {
    port.next = taken;  // the next request may share the cycle
  } else {
    port.next = taken + 1 + (one_by_one_ ? count : 0);
    port.begin_cycle();
  }
  if (later != 0) {
    port.queue.front().sectors = later;
  } else {
    port.queue.pop();
  }
  if (on_the_way != 0) {
    Cycle last = 0;
    const std::uint8_t awaited = fills_[filling].awaited(on_the_way, at, last);
    if (awaited != on_the_way) seen = std::max(seen, through);
    if (awaited != 0) seen = std::max(seen, last + 1);
    present |= on_the_way ^ awaited;
    on_the_way = awaited;
  }
  count_access<kClient>(slot, r, present, on_the_way, filling);
  if (slot != SectorCacheTags::kNone) tags_.touch(slot);
  if (effect.keep) keep_write(slot, r.line, r.sectors, r.region, effect.dirty, taken, true);
  if (missing != 0) seen = std::max(seen, send_miss(filling, r, missing, kClient == kPrefetch, at));
  if (kClient == kNode) seen = return_nodes(count, taken, seen, seen == through);
  deliver<kClient>(r, seen);
  return missing != 0 ? Taken::miss : Taken::hit;
}

Cycle L1::return_nodes(unsigned count, Cycle taken, Cycle seen, bool in_pipeline) {
  const unsigned width = ports_[kNode].width;
  if (width == 1) {
    link_pushed_ = link_.take_in_turn(taken, count) + 1;
    if (responses_.reserve_run(seen, count, in_pipeline)) {
      if (in_pipeline) hits_.take_in_turn(seen, count);
      return seen;
    }
  } else {
    const Cycle begun = taken - (count - 1) / width;
    for (unsigned i = 0; i < count; ++i) {
      link_pushed_ = link_.room() + 1;
      link_.take(begun + i / width);
    }
  }
  const Cycle first = seen - (count - 1) / width;
  for (unsigned i = 0; i < count; ++i) {
    const Cycle place = (first + i / width) * width;
    seen = (in_pipeline ? responses_.reserve_hit(place) : responses_.reserve_fill(place)) / width;
    if (in_pipeline) hits_.take(seen);
  }
  return seen;
}

template <Client kClient>
void L1::count_access(SectorCacheTags::Slot slot, const Request& r, std::uint8_t present, std::uint8_t on_the_way,
                      std::uint32_t filling) {
  RegionCounters& region = counters_.region[static_cast<std::size_t>(r.region)];
  const unsigned count = count_of(r.sectors), hits = count_of(present), awaited = count_of(on_the_way);
  counters_.responses += count;
  if (kClient == kPrefetch) {
    counters_.prefetches += count;
    counters_.prefetches_redundant += hits + awaited;
    return;
  }
  if ((kClient == kSimt || kClient == kCheckpoint || kClient == kStack) && r.write) {
    region.writes += count;
    region.write_hits += hits;
  } else {
    region.reads += count;
    region.hits += hits;
    region.hits_on_miss += awaited;
    region.misses += count - hits - awaited;
  }
  if (slot != SectorCacheTags::kNone) demand(slot, present);
  if (filling != AddressIndex::kNone) demand(fills_[filling], present | on_the_way, on_the_way);
}

void L1::demand(SectorCacheTags::Slot slot, std::uint8_t sectors) {
  const auto first = static_cast<std::uint8_t>(tags_.unused_prefetch(slot) & sectors);
  if (first == 0) return;
  counters_.prefetches_useful += count_of(first);
  tags_.clear_unused_prefetch(slot, first);
}

void L1::demand(Fill& fill, std::uint8_t sectors, std::uint8_t awaited) {
  counters_.prefetches_useful += count_of(fill.prefetched & sectors & ~awaited);
  counters_.prefetches_late += count_of(fill.prefetched & awaited);
  fill.prefetched &= static_cast<std::uint8_t>(~sectors);
}

// Returns when the answer can be seen.
Cycle L1::send_miss(std::uint32_t filling, const Request& r, std::uint8_t missing, bool prefetched, Cycle at) {
  const unsigned count = count_of(missing);
  const FastMemory::Trip trip =
      shared_.memory.access({sm_, r.line, missing, r.region, r.write}, at + config_.tag_latency);
  crossed_.take(trip.crossed, count);
  if (r.write) {
    counters_.sent_writes += count;
    return trip.seen + 1;
  }
  counters_.sent_reads += count;
  counters_.mshr_cycles += count * (trip.seen - at);
  counters_.miss_latency.add(trip.seen - at, count);
  mshrs_.take(trip.seen, count);
  if (prefetched) counters_.prefetches_fetched += count;
  if (filling == AddressIndex::kNone) {
    if (free_fills_.empty()) {  // a memory so slow that the MSHRs' calendar ends before it answers
      place(r.line, missing, prefetched ? missing : std::uint8_t{0}, trip.seen);
      return trip.seen + 1;
    }
    filling = free_fills_.back();
    free_fills_.pop_back();
    filling_.insert(r.line / kSectorBytes, filling);
    fills_[filling].line = r.line;
    fills_[filling].sectors = fills_[filling].prefetched = 0;
    shared_.agenda.add(trip.seen, {What::l1_fill, sm_, filling});
  }
  Fill& fill = fills_[filling];
  fill.sectors |= missing;
  if (prefetched) fill.prefetched |= missing;
  fill.complete = fill.sectors == missing ? trip.seen : std::max(fill.complete, trip.seen);
  for (std::uint8_t rest = missing; rest != 0; rest &= static_cast<std::uint8_t>(rest - 1)) {
    fill.arrives[static_cast<unsigned>(std::countr_zero(rest))] = NearCycle(trip.seen);
  }
  return trip.seen + 1;
}

// All sectors that were on their way when the first came take their place together.
void L1::fill(Cycle now, std::uint32_t number) {
  const Fill& fill = fills_[number];
  if (fill.complete > now) return shared_.agenda.add(fill.complete, {What::l1_fill, sm_, number});
  place(fill.line, fill.sectors, fill.prefetched, now);
  filling_.erase(fill.line / kSectorBytes);
  free_fills_.push_back(number);
}

void L1::place(std::uint64_t line, std::uint8_t sectors, std::uint8_t prefetched, Cycle now) {
  counters_.fills += count_of(sectors);
  SectorCacheTags::Slot slot = tags_.find(line);
  if (slot == SectorCacheTags::kNone) {
    const SectorCacheTags::Slot replaced =
        victim_can_leave(line, now) ? tags_.victim_slot(line) : tags_.clean_victim(line);
    if (replaced == SectorCacheTags::kNone) {
      counters_.fills_bypassed += count_of(sectors);
      counters_.prefetches_unused += count_of(prefetched);
      return;
    }
    slot = allocate(line, replaced, now, true);
  }
  tags_.set_valid(slot, sectors);
  if (prefetched != 0) tags_.set_unused_prefetch(slot, prefetched);
}

SectorCacheTags::Slot L1::allocate(std::uint64_t line, SectorCacheTags::Slot place, Cycle now, bool timed) {
  SectorCacheTags::Victim victim;
  const SectorCacheTags::Slot slot = tags_.insert_at(place, line, &victim);
  counters_.prefetches_unused += count_of(victim.unused_prefetch);
  if (victim.valid && timed) ++counters_.evictions;
  if (victim.dirty == 0) return slot;
  const FastMemory::Request write_back{sm_, victim.address, victim.dirty, written_by_[slot], true};
  if (!timed) {
    shared_.memory.warm(write_back);
    return slot;
  }
  const unsigned count = count_of(victim.dirty);
  leaving_.take(shared_.memory.access(write_back, now + config_.tag_latency).crossed);
  counters_.sent_writes += count;
  counters_.write_backs += count;
  return slot;
}

void L1::keep_write(SectorCacheTags::Slot slot, std::uint64_t line, std::uint8_t sectors, Region region, bool dirty,
                    Cycle now, bool timed) {
  if (slot == SectorCacheTags::kNone) slot = allocate(line, now, timed);
  tags_.set_valid(slot, sectors);
  if (!dirty) return;
  if (timed) {
    counters_.kept_writes += count_of(sectors);
    counters_.rewrites += count_of(sectors & tags_.dirty(slot));
  }
  tags_.set_dirty(slot, sectors);
  written_by_[slot] = region;
}

template <Client kClient>
void L1::deliver(const Request& r, Cycle seen) {
  if constexpr (kClient == kNode) {
    rt_->node_arrives(r.owner, seen, r.last, link_pushed_);
  } else if constexpr (kClient == kCheckpoint) {
    rt_->checkpoints().answered(r.owner, seen, r.write, r.last);
  } else if constexpr (kClient == kStack) {
    rt_->stacks().answered(r.owner, seen, r.write);
  } else if constexpr (kClient == kSimt) {
    simt_->answered(r.owner, seen, r.write);
  }
}

// What a prefetch brings in here has no mark: the marks are counted.
void L1::warm_caches(Client client, std::uint64_t line, std::uint8_t sectors, Region region, bool write) {
  if (config_.perfect) return;
  SectorCacheTags::Slot slot = tags_.find(line);
  std::uint8_t missing = sectors;
  if (slot != SectorCacheTags::kNone) {
    tags_.touch(slot);
    const auto present = static_cast<std::uint8_t>(sectors & tags_.valid(slot));
    if (client != kPrefetch) demand(slot, present);
    if (!write) missing ^= present;
  }
  if (write) {
    const PrivateWrites::Effect effect = config_.private_writes.effect(region, slot != SectorCacheTags::kNone);
    if (effect.keep) keep_write(slot, line, sectors, region, effect.dirty, 0, false);
    if (!effect.forward) return;
  }
  if (missing == 0) return;
  if (!write) {
    if (const std::uint32_t filling = filling_.find(line / kSectorBytes); filling != AddressIndex::kNone) {
      Fill& fill = fills_[filling];
      const auto on_the_way = static_cast<std::uint8_t>(missing & fill.sectors);
      // In time: while a fill is under way others do `stride` times as much here, and would mostly come after it.
      if (client != kPrefetch) demand(fill, on_the_way, 0);
      missing ^= on_the_way;
      if (missing == 0) return;
    }
  }
  shared_.memory.warm({sm_, line, missing, region, write});
  if (write) return;
  if (slot == SectorCacheTags::kNone) slot = allocate(line, 0, false);
  tags_.set_valid(slot, missing);
}

}  // namespace grtx::sim::fast
