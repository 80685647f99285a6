// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/cache/l1_cache.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <ostream>

#include "grtx/base/error.h"

namespace grtx::modules {
L1Cache::L1Cache(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock)
    : L1CacheModule(name, clock, config.clients),
      config_(config),
      clients_(config.clients),
      waiting_(config.clients),
      response_due_(config.clients, kNever),
      tags_(config.geometry),
      mshrs_(config.mshr_entries, config.mshr_merges),
      writes_back_(config.private_writes.policy == WritePolicy::write_back),
      written_by_(writes_back_ ? tags_.slots() : 0),
      miss_queue_(config.miss_queue +
                  (writes_back_ ? std::size_t{config.write_back_buffer} * config.geometry.sectors() : 0)),
      bank_mask_(std::has_single_bit(config.banks) ? config.banks - 1 : 0) {
  const auto require = [](bool holds, const char* rule) {
    if (!holds) throw Error("configuration", "l1", rule);
  };
  require(config.clients >= 1 && config.clients <= 256, "clients must be 1 to 256");
  require_allowed("l1", config);
  require(config.geometry.sector_bytes == kSectorBytes, "sectors must be 32 bytes, the size of a request");
}

void L1Cache::end_of_elaboration() {
  down_ = writer_of(to_memory);
  up_ = reader_of(from_memory);
  up_.wake(&alarm_);
  for (unsigned i = 0; i < config_.clients; ++i) {
    if (i < config_.widths.size()) clients_[i].width = config_.widths[i];
    clients_[i].hit_places = config_.latency * clients_[i].width;
    clients_[i].request = reader_of(request[i]);
    clients_[i].request.wake(&alarm_);
    waiting_.watch(i, clients_[i].request);
    clients_[i].response = writer_of(response[i]);
    const unsigned link = clients_[i].response.latency();
    if (config_.latency < link) throw Error("configuration", "l1", "latency is shorter than the response link's");
    clients_[i].hit_latency = config_.latency - link;
  }
}

void L1Cache::restart(Caches caches) {
  tags_.restart(caches == Caches::warm);
  mshrs_ = MshrTable(config_.mshr_entries, config_.mshr_merges);
  for (Client& client : clients_) {
    client.hits.clear();
    client.fills.clear();
    client.hit_reads.clear();
    client.fill_reads.clear();
    client.refused = {};
  }
  miss_queue_.clear();
  leaving_sectors_ = leaving_lines_ = 0;
  writes_pending_ = 0;
  std::fill(response_due_.begin(), response_due_.end(), kNever);
  first_client_ = 0;
  banks_taken_ = version_ = 0;
  next_request_ = next_response_ = kNever;
  mshr_counted_ = 0;
  ticked_ = kNever;
  dirty_at_start_ = tags_.count_dirty();
  counters_ = {};
}

void L1Cache::preload(std::uint64_t address) {
  counters_.prefetches_unused += static_cast<std::uint64_t>(
      std::popcount(tags_.preload(address, {.address = address, .sm = config_.sm}).unused_prefetch));
}

void L1Cache::save(StateWriter& state) const {
  assert(idle());
  tags_.save(state);
  save_regions(written_by_, state);
}

void L1Cache::load(StateReader& state) {
  tags_.load(state);
  load_regions(written_by_, state);
  dirty_at_start_ = tags_.count_dirty();
}

// The most frequently called function of the model. What it always does is inlined, what it seldom does is not: its
// instructions stay in the host's cache.
Cycle L1Cache::tick(Cycle now) { return stages_ == nullptr ? work<false>(now) : work<true>(now); }

template <bool kObserved>
inline Cycle L1Cache::work(Cycle now) {
  if (now == ticked_) {  // read_at_once() has called it; since then requests may have been sent
    for (const Client& client : clients_) next_request_ = std::min(next_request_, client.request.next_visible());
    return next_due(now);
  }
  ticked_ = now;
  // Before the requests, so that a sector filled in this cycle hits in this cycle.
  if (up_.next_visible() <= now) take_response(now);
  take_requests<kObserved>(now);
  if (!miss_queue_.empty() && miss_queue_.front().due <= now) send_miss(now);
  if (next_response_ <= now) send_responses<kObserved>(now);
  return next_due(now);
}

// The fill port: one sector or acknowledgement per cycle.
[[gnu::noinline]] void L1Cache::take_response(Cycle now) {
  const MemoryResponse* arrived = up_.front(now);
  if (arrived == nullptr) return;
  if (arrived->write) {
    assert(writes_pending_ > 0 && arrived->client < clients_.size());
    --writes_pending_;
    if (!arrived->write_back) {
      clients_[arrived->client].fills.push({*arrived, now});
      if (stages_ != nullptr) clients_[arrived->client].fill_reads.push({});
      respond_at(now, arrived->client);
    }
  } else {
    fill(now, arrived->tag, arrived->address);
  }
  up_.pop(now);
}

void L1Cache::install(Cycle now, std::uint32_t mshr, std::uint64_t address) {
  SectorCacheTags::Slot slot = tags_.find(address);
  if (slot == SectorCacheTags::kNone) {
    // A fill never waits for a write-back: the write-back's path may depend on this fill port, a deadlock.
    const MemoryRequest access = mshrs_.first(mshr);
    const SectorCacheTags::Slot place =
        room_for_victim(access) ? tags_.victim_slot(address, access) : tags_.clean_victim(address, access);
    if (place != SectorCacheTags::kNone) slot = allocate(now, access, place);
  }
  if (slot != SectorCacheTags::kNone) {
    const std::uint8_t sector = tags_.sector_bit(address);
    tags_.set_valid(slot, sector);
    if (!mshrs_.demanded(mshr)) tags_.set_unused_prefetch(slot, sector);
  } else {
    ++counters_.fills_bypassed;
    if (!mshrs_.demanded(mshr)) ++counters_.prefetches_unused;
  }
}

void L1Cache::fill(Cycle now, std::uint32_t mshr, std::uint64_t address) {
  assert(mshrs_.in_use(mshr) && mshrs_.sector_address(mshr) == address);
  install(now, mshr, address);
  ++counters_.fills;
  counters_.miss_latency.add(now - mshrs_.allocated(mshr));
  std::size_t waiter = 0;
  for (const MshrWaiter& w : mshrs_.waiters(mshr)) {
    clients_[w.client].fills.push({{address, w.tag, w.client, w.sm, w.region, w.write, w.prefetch}, now});
    if (stages_ != nullptr) clients_[w.client].fill_reads.push(stages_->fills_l1(config_.sm, mshr, waiter++, now));
    respond_at(now, w.client);
  }
  ++version_;
  count_mshr_cycles(now);
  mshrs_.release(mshr);
}

// A port accepts up to `width` requests per cycle, a bank one. Clients are tried in priority order, so the first one
// wins a contested bank.
template <bool kObserved>
[[gnu::always_inline]] inline void L1Cache::take_requests(Cycle now) {
  banks_taken_ = 0;
  next_request_ = kNever;
  bool won = false;
  waiting_.for_each_from(
      first_client_, [&](unsigned i) __attribute__((always_inline)) { take_from<kObserved>(now, i, won); });
}

template <bool kObserved>
[[gnu::always_inline]] inline void L1Cache::take_from(Cycle now, unsigned i, bool& won) {
  Client& client = clients_[i];
  for (unsigned left = client.width; left > 0; --left) {
    const MemoryRequest* head = client.request.front(now);
    if (head == nullptr) break;
    if constexpr (kObserved) asked_ = client.request.next_visible();
    if (!accept<kObserved>(now, i, *head)) {
      next_request_ = now;
      return;
    }
    if (!won && config_.rotating_priority) first_client_ = i + 1 == config_.clients ? 0 : i + 1;
    won = true;
    client.request.pop(now);
  }
  waiting_.popped(i, client.request);
  next_request_ = std::min(next_request_, client.request.next_visible());
}

bool L1Cache::stall(L1Stall reason) {
  ++counters_.stalls[static_cast<std::size_t>(reason)];
  return false;
}

bool L1Cache::refuse(Client& client, L1Stall reason) {
  client.refused = {version_, reason};
  return stall(reason);
}

template <bool kObserved>
[[gnu::always_inline]] inline bool L1Cache::accept(Cycle now, unsigned port, const MemoryRequest& access) {
  Client& client = clients_[port];
  assert(access.address % kSectorBytes == 0);
  // A blocked response port backs up the hit pipeline as far as the request port.
  if (client.hits.size() >= client.hit_places) return stall(L1Stall::response_port);
  const std::uint64_t sector = access.address / kSectorBytes;
  const std::uint64_t bank = std::uint64_t{1} << (bank_mask_ != 0 ? sector & bank_mask_ : sector % config_.banks);
  if ((banks_taken_ & bank) != 0) return stall(L1Stall::bank_conflict);
  // A refused request is refused again until something inside has changed.
  if (client.refused.at == version_) return stall(client.refused.reason);
  const bool accepted = access.write ? accept_write(now, port, access) : accept_read<kObserved>(now, port, access);
  if (accepted) {
    banks_taken_ |= bank;
    client.refused.at = kNever;
  }
  return accepted;
}

// A hit, the usual case, or accept_miss().
template <bool kObserved>
[[gnu::always_inline]] inline bool L1Cache::accept_read(Cycle now, unsigned port, const MemoryRequest& access) {
  const SectorCacheTags::Slot slot = config_.perfect ? SectorCacheTags::kNone : tags_.find(access.address);
  const std::uint8_t sector = tags_.sector_bit(access.address);
  const bool present = slot != SectorCacheTags::kNone && (tags_.valid(slot) & sector) != 0;
  if (!present && !config_.perfect) return accept_miss(now, port, access, slot);

  answer_hit<kObserved>(now, port, access);
  count_hit(port, access, slot, sector, present);
  return true;
}

inline void L1Cache::count_hit(unsigned port, const MemoryRequest& access, SectorCacheTags::Slot slot,
                               std::uint8_t sector, bool present) {
  if (present) tags_.touch(slot, [&] { return from_port(port, access); });
  if (access.prefetch) {
    ++counters_.prefetches;
    ++counters_.prefetches_redundant;
    return;
  }
  RegionCounters& region = counters_.region[index(access.region)];
  ++region.reads;
  ++region.hits;
  if (present) reference(slot, sector);
}

ReadAtOnce L1Cache::read_at_once(Cycle now, const MemoryRequest& access) {
  constexpr unsigned kClient = 0;
  asked_ = now;
  if (ticked_ != now) alarm_.request(tick(now));
  const SectorCacheTags::Slot slot = config_.perfect ? SectorCacheTags::kNone : tags_.find(access.address);
  const std::uint8_t sector = tags_.sector_bit(access.address);
  const bool present = slot != SectorCacheTags::kNone && (tags_.valid(slot) & sector) != 0;
  if (present || config_.perfect) {
    count_hit(kClient, access, slot, sector, present);
    if (stages_ != nullptr) stages_->served(access.region, {now, now, {}}, now);
    ++counters_.responses;
    return ReadAtOnce::hit;
  }
  if (!accept_miss(now, kClient, access, slot)) return ReadAtOnce::refused;
  alarm_.request(next_due(now));
  return ReadAtOnce::under_way;
}

// slot: the line, which is present without the sector, or kNone.
[[gnu::noinline]] bool L1Cache::accept_miss(Cycle now, unsigned port, const MemoryRequest& access,
                                            SectorCacheTags::Slot slot) {
  const std::uint32_t pending = mshrs_.find(access.address);
  const bool miss = pending == MshrTable::kNone;
  if (miss) {
    if (mshrs_.full()) return refuse(clients_[port], L1Stall::mshr_full);
    if (!room_to_send(1)) return refuse(clients_[port], L1Stall::miss_queue_full);
  } else if (mshrs_.merges_full(pending)) {
    return refuse(clients_[port], L1Stall::merges_full);
  }

  const MemoryRequest from = from_port(port, access);
  if (slot != SectorCacheTags::kNone) tags_.touch(slot, [&] { return from; });
  if (!miss) {
    if (!access.prefetch && !mshrs_.demanded(pending)) ++counters_.prefetches_late;
    mshrs_.merge(pending, from);
  } else {
    count_mshr_cycles(now);
    MemoryRequest down = from;
    down.tag = mshrs_.allocate(now, access.address, from);
    miss_queue_.push({down, now + config_.tag_latency, false});
  }
  if (stages_ != nullptr) stages_->waits(config_.sm, miss ? mshrs_.find(access.address) : pending, asked_, now, miss);
  ++version_;

  if (access.prefetch) {
    ++counters_.prefetches;
    ++(miss ? counters_.prefetches_fetched : counters_.prefetches_redundant);
    return true;
  }
  RegionCounters& region = counters_.region[index(access.region)];
  ++region.reads;
  ++(miss ? region.misses : region.hits_on_miss);
  return true;
}

[[gnu::noinline]] bool L1Cache::accept_write(Cycle now, unsigned port, const MemoryRequest& access) {
  Client& client = clients_[port];
  RegionCounters& region = counters_.region[index(access.region)];
  const auto answer = [&] {
    stages_ == nullptr ? answer_hit<false>(now, port, access) : answer_hit<true>(now, port, access);
  };
  if (config_.perfect) {
    answer();
    ++region.writes;
    ++region.write_hits;
    return true;
  }
  SectorCacheTags::Slot slot = tags_.find(access.address);
  const std::uint8_t sector = tags_.sector_bit(access.address);
  const bool present = slot != SectorCacheTags::kNone;
  const PrivateWrites::Effect effect = config_.private_writes.effect(access.region, present);
  if (effect.forward && !room_to_send(1)) return refuse(client, L1Stall::miss_queue_full);
  if (effect.keep && !present && !room_for_victim(from_port(port, access))) {
    return stall(L1Stall::miss_queue_full);  // not refuse(): any access may change which line is the victim
  }
  ++region.writes;
  if (present) {
    tags_.touch(slot, [&] { return from_port(port, access); });
    if ((tags_.valid(slot) & sector) != 0) {
      ++region.write_hits;
      reference(slot, sector);
    }
  }
  if (effect.keep) {
    if (!present) slot = allocate(now, from_port(port, access));
    tags_.set_valid(slot, sector);
    ++version_;
  }
  if (effect.dirty) {
    if ((tags_.dirty(slot) & sector) != 0) ++counters_.rewrites;
    tags_.set_dirty(slot, sector);
    written_by_[slot] = access.region;
    ++counters_.kept_writes;
    answer();
  }
  if (effect.forward) {
    miss_queue_.push({from_port(port, access), now + config_.tag_latency, false});
    ++version_;
    ++writes_pending_;
  }
  return true;
}

SectorCacheTags::Slot L1Cache::allocate(Cycle now, const MemoryRequest& access, SectorCacheTags::Slot place) {
  SectorCacheTags::Victim victim;
  const SectorCacheTags::Slot slot = tags_.insert_at(place, access.address, access, &victim);
  if (victim.valid) ++counters_.evictions;
  counters_.prefetches_unused += static_cast<std::uint64_t>(std::popcount(victim.unused_prefetch));
  if (victim.dirty != 0) push_dirty(now, victim, written_by_[slot]);  // the slot still holds the victim's region
  return slot;
}

void L1Cache::push_dirty(Cycle now, const SectorCacheTags::Victim& victim, Region region) {
  ++leaving_lines_;
  for (std::uint8_t dirty = victim.dirty; dirty != 0; dirty &= static_cast<std::uint8_t>(dirty - 1)) {
    MemoryRequest dirty_sector;
    dirty_sector.address = victim.address + static_cast<std::uint64_t>(std::countr_zero(dirty)) * kSectorBytes;
    dirty_sector.sm = config_.sm;
    dirty_sector.region = region;
    dirty_sector.write = dirty_sector.write_back = true;
    miss_queue_.push({dirty_sector, now + config_.tag_latency, std::has_single_bit(dirty)});
    ++leaving_sectors_;
    ++writes_pending_;
    ++counters_.write_backs;
  }
}

template <bool kObserved>
inline void L1Cache::answer_hit(Cycle now, unsigned port, const MemoryRequest& access) {
  Client& client = clients_[port];
  const Cycle due = now + client.hit_latency;
  Pending& hit = client.hits.add();
  hit.response = response_to(access);
  hit.response.client = static_cast<std::uint8_t>(port);
  hit.response.sm = config_.sm;
  hit.due = due;
  if constexpr (kObserved) client.hit_reads.push({asked_, now, {static_cast<std::uint32_t>(now - asked_)}});
  respond_at(due, port);
}

inline void L1Cache::reference(SectorCacheTags::Slot slot, std::uint8_t sector) {
  if ((tags_.unused_prefetch(slot) & sector) == 0) return;
  tags_.clear_unused_prefetch(slot, sector);
  ++counters_.prefetches_useful;
}

[[gnu::noinline]] void L1Cache::send_miss(Cycle now) {
  const MemoryRequest& miss = miss_queue_.front().request;
  if (!down_.try_push(now, miss)) return;
  ++(miss.write ? counters_.sent_writes : counters_.sent_reads);
  if (stages_ != nullptr && !miss.write) stages_->leaves_l1(config_.sm, miss.tag, now);
  if (miss.write_back) --leaving_sectors_;
  if (miss_queue_.front().line_gone) --leaving_lines_;
  miss_queue_.pop();
  ++version_;
}

// Up to `width` responses per client and cycle: earliest due first, a hit before a fill of the same cycle.
template <bool kObserved>
[[gnu::always_inline]] inline void L1Cache::send_responses(Cycle now) {
  Cycle* const due = response_due_.data();
  const std::size_t clients = config_.clients;
  Cycle next = kNever;
  for (std::size_t i = 0; i < clients; ++i) {
    if (due[i] <= now) due[i] = send_response<kObserved>(now, clients_[i]);
    next = std::min(next, due[i]);
  }
  next_response_ = next;
}

// Returns when the client's next response is due.
template <bool kObserved>
[[gnu::always_inline]] inline Cycle L1Cache::send_response(Cycle now, Client& client) {
  const auto first_due = [](const RingQueue<Pending>& queue) { return queue.empty() ? kNever : queue.front().due; };
  Cycle hit = first_due(client.hits);
  Cycle filled = first_due(client.fills);
  unsigned left = client.width;
  do {
    const bool hit_first = hit <= filled;
    RingQueue<Pending>& queue = hit_first ? client.hits : client.fills;
    if (!client.response.try_push(now, queue.front().response)) break;
    if constexpr (kObserved) report(client, hit_first, now);
    queue.pop();
    ++counters_.responses;
    (hit_first ? hit : filled) = first_due(queue);
  } while (--left > 0 && std::min(hit, filled) <= now);
  return std::min(hit, filled);
}

[[gnu::noinline]] void L1Cache::report(Client& client, bool hit, Cycle now) {
  RingQueue<ServedRead>& reads = hit ? client.hit_reads : client.fill_reads;
  const MemoryResponse& sent = (hit ? client.hits : client.fills).front().response;
  if (!sent.write && !sent.prefetch) stages_->served(sent.region, reads.front(), now + client.response.latency());
  reads.pop();
}

[[gnu::always_inline]] inline Cycle L1Cache::next_due(Cycle now) const {
  Cycle due = std::min(up_.next_visible(), std::min(next_request_, next_response_));
  if (!miss_queue_.empty()) due = std::min(due, miss_queue_.front().due);
  return std::max(now + 1, due);
}

void L1Cache::count_mshr_cycles(Cycle now) {
  counters_.mshr_cycles += mshrs_.used() * (now - mshr_counted_);
  mshr_counted_ = now;
}

bool L1Cache::idle() const {
  const bool quiet = std::all_of(clients_.begin(), clients_.end(), [](const Client& c) {
    return c.hits.empty() && c.fills.empty() && c.request.empty();
  });
  return quiet && miss_queue_.empty() && mshrs_.used() == 0 && writes_pending_ == 0 && up_.empty();
}

L1Counters L1Cache::counters() const {
  L1Counters counters = counters_;
  counters.prefetches_unused += tags_.count_unused_prefetch();
  return counters;
}

void L1Cache::statistics(StatisticList& list, const std::string& prefix) const { counters().describe(list, prefix); }

Inventory L1Cache::inventory() const {
  const unsigned mshr_bits = kAddressBits - 5 + 1;       // sector address, valid
  const unsigned waiter_bits = 32 + 8 + 4 + 1;           // tag, client, region, prefetch
  const unsigned miss_bits = kAddressBits - 5 + 32 + 2;  // address, tag or MSHR number, kind
  const std::uint64_t lines = config_.geometry.sets() * config_.geometry.ways;
  Inventory inventory;
  inventory.module = this->name();
  inventory.storage = {
      {"data", StorageKind::cache, lines * config_.geometry.line_bytes * 8, config_.banks, 1, false, 256},
      // More than 16 ways are searched in parallel, with a comparator at each tag.
      {"tags", config_.geometry.ways > 16 ? StorageKind::flip_flop : StorageKind::cache_tags,
       tags_.tag_bits(kAddressBits, writes_back_), 1, 1, false},
      {"mshr", StorageKind::flip_flop,
       std::uint64_t{config_.mshr_entries} * (mshr_bits + std::uint64_t{config_.mshr_merges} * waiter_bits), 1, 1,
       false},
      {"miss_queue", StorageKind::ram, std::uint64_t{config_.miss_queue} * miss_bits, 1, 1, false}};
  if (writes_back_) {  // data, address, and which sectors are dirty
    const std::uint64_t line_bits =
        std::uint64_t{config_.geometry.line_bytes} * 8 + kAddressBits - 7 + config_.geometry.sectors();
    inventory.storage.push_back(
        {"write_back_buffer", StorageKind::ram, config_.write_back_buffer * line_bits, 1, 1, false});
  }
  inventory.operators = {
      {"match", kAddressBits - 7, std::uint64_t{config_.geometry.ways} * config_.banks},  // tag comparators
      {"match", kAddressBits - 5, config_.mshr_entries}};
  return inventory;
}

void L1Cache::dump_state(std::ostream& out) const {
  out << name() << ": mshr " << mshrs_.used() << '/' << config_.mshr_entries << ", miss queue "
      << miss_queue_.size() - leaving_sectors_ << '/' << config_.miss_queue << ", write-back buffer " << leaving_lines_
      << ", writes pending " << writes_pending_ << '\n';
  for (std::size_t i = 0; i < clients_.size(); ++i) {
    const Client& c = clients_[i];
    out << "  client " << i << ": requests " << c.request.size() << ", hit pipe " << c.hits.size() << ", fill queue "
        << c.fills.size() << '\n';
  }
  mshrs_.dump_state(out);
}

ReadAtOnce L1CacheModule::read_at_once(Cycle /*now*/, const MemoryRequest& /*sector*/) {
  throw Error("L1", name(), "does not answer in the cycle of the request, which rt.memory.l1_hit_latency needs");
}

void L1CacheModule::save(StateWriter& /*state*/) const { refuse_state(*this); }

void L1CacheModule::load(StateReader& /*state*/) { refuse_state(*this); }

std::unique_ptr<L1CacheModule> make_l1_cache(const sc_core::sc_module_name& name, const L1CacheConfig& config,
                                             ClockDomain& clock) {
  return std::make_unique<L1Cache>(name, config, clock);
}

}  // namespace grtx::modules
