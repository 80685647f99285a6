#include "rtl_tlm/fast/fast_l1.h"

#include <algorithm>
#include <bit>

namespace grtx::tlm {

using modules::kNever;
using modules::L1Stall;
using modules::MemoryRequest;
using modules::SectorCacheTags;

FastL1::FastL1(const modules::L1Cache::Config& config, unsigned sm, std::size_t link_capacity, FastMemory& memory)
    : config_(config),
      sm_(static_cast<std::uint8_t>(sm)),
      memory_(memory),
      tags_(config.geometry),
      banks_(config.banks),
      bank_mask_(std::has_single_bit(config.banks) ? config.banks - 1 : 0),
      misses_(config.mshr_entries),
      arrivals_(config.mshr_entries),
      pending_(config.mshr_entries),
      crossed_(config.miss_queue + link_capacity) {
  for (unsigned i = config.mshr_entries; i > 0; --i) free_.push_back(static_cast<DueWheel::Number>(i - 1));
}

void FastL1::fill_next() {
  arrivals_.take(arrivals_.next(), [this](DueWheel::Number number) { store(number); });
}

void FastL1::store(DueWheel::Number number) {
  const Miss& miss = misses_[number];
  SectorCacheTags::Slot slot = tags_.find(miss.address);
  if (slot == SectorCacheTags::kNone) {
    SectorCacheTags::Victim victim;
    slot = tags_.insert(miss.address, &victim);
    if (victim.valid) ++counters_.evictions;
    counters_.prefetches_unused += static_cast<std::uint64_t>(std::popcount(victim.unused_prefetch));
  }
  const std::uint8_t sector = tags_.sector_bit(miss.address);
  tags_.set_valid(slot, sector);
  if (!miss.demanded) tags_.set_unused_prefetch(slot, sector);
  ++counters_.fills;
  pending_.erase(miss.address / modules::kSectorBytes);
  free_.push_back(number);
}

Cycle FastL1::take_bank(Cycle now, const MemoryRequest& request, Client client) {
  const std::uint64_t sector = request.address / modules::kSectorBytes;
  const Cycle bank = banks_[bank_mask_ != 0 ? sector & bank_mask_ : sector % banks_.size()].reserve(now);
  if (bank == now) return now;
  if (client != kNode && (between_ = !between_)) {
    ++overtaken_;
    return now;
  }
  counters_.stalls[static_cast<std::size_t>(L1Stall::bank_conflict)] += bank - now;
  return bank;
}

bool FastL1::turn_of(Cycle now, Client client) {
  for (unsigned other = first_; other != client; other = (other + 1) % kClients) {
    if (again_[other] != 0 && again_[other] <= now) return false;
  }
  first_ = (client + 1u) % kClients;
  return true;
}

FastL1::Access FastL1::refuse(Cycle now, Cycle until, Client client, L1Stall reason) {
  again_[client] = until;
  counters_.stalls[static_cast<std::size_t>(reason)] += until - now;
  return {kNever, until, false};
}

FastMemory::Trip FastL1::send(Cycle now, MemoryRequest request) {
  request.sm = sm_;
  const FastMemory::Trip trip = memory_.access(request, now + config_.tag_latency);
  crossed_[next_crossed_] = trip.crossed;
  next_crossed_ = next_crossed_ + 1 == crossed_.size() ? 0 : next_crossed_ + 1;
  return trip;
}

FastL1::Access FastL1::read(Cycle now, const MemoryRequest& request, Client client) {
  modules::L1Counters::ByRegion& region = counters_.region[static_cast<std::size_t>(request.region)];
  const auto accept = [&](std::uint64_t& as_prefetch, std::uint64_t& as_read) {
    again_[client] = 0;
    ++counters_.responses;
    ++(request.prefetch ? counters_.prefetches : region.reads);
    ++(request.prefetch ? as_prefetch : as_read);
  };
  if (config_.perfect) {
    accept(counters_.prefetches_redundant, region.hits);
    now = take_bank(now, request, client);
    return {now, now + config_.latency, true};
  }
  fill(now);
  const SectorCacheTags::Slot slot = tags_.find(request.address);
  if (slot != SectorCacheTags::kNone) {
    const std::uint8_t sector = tags_.sector_bit(request.address);
    if ((tags_.valid(slot) & sector) != 0) {
      tags_.touch(slot);
      accept(counters_.prefetches_redundant, region.hits);
      if (!request.prefetch) reference(slot, sector);
      now = take_bank(now, request, client);
      return {now, now + config_.latency, true};
    }
  }
  const std::uint64_t number = request.address / modules::kSectorBytes;
  if (const std::uint32_t under_way = pending_.find(number); under_way != modules::AddressIndex::kNone) {
    Miss& miss = misses_[under_way];
    if (slot != SectorCacheTags::kNone) tags_.touch(slot);
    accept(counters_.prefetches_redundant, region.hits_on_miss);
    if (!request.prefetch) {
      if (!miss.demanded) ++counters_.prefetches_late;
      miss.demanded = true;
    }
    now = take_bank(now, request, client);
    return {now, std::max(now + config_.latency, miss.arrives + 1), false};
  }
  if (free_.empty()) return refuse(now, arrivals_.next(), client, L1Stall::mshr_full);
  if (const Cycle free = room(); free > now) return refuse(now, free, client, L1Stall::miss_queue_full);
  if (!turn_of(now, client)) return refuse(now, now + 1, client, L1Stall::miss_queue_full);
  if (slot != SectorCacheTags::kNone) tags_.touch(slot);
  accept(counters_.prefetches_fetched, region.misses);
  now = take_bank(now, request, client);
  const FastMemory::Trip trip = send(now, request);
  const DueWheel::Number miss = free_.back();
  free_.pop_back();
  misses_[miss] = {request.address, trip.seen, !request.prefetch};
  arrivals_.add(now, trip.seen, miss);
  pending_.insert(number, miss);
  ++counters_.sent_reads;
  counters_.miss_latency.add(trip.seen - now);
  counters_.mshr_cycles += trip.seen - now;
  return {now, trip.seen + 1, false};
}

void FastL1::reference(SectorCacheTags::Slot slot, std::uint8_t sector) {
  if ((tags_.unused_prefetch(slot) & sector) == 0) return;
  tags_.clear_unused_prefetch(slot, sector);
  ++counters_.prefetches_useful;
}

FastL1::Access FastL1::write(Cycle now, const MemoryRequest& request, Client client) {
  modules::L1Counters::ByRegion& region = counters_.region[static_cast<std::size_t>(request.region)];
  if (!config_.perfect) {
    fill(now);
    if (const Cycle free = room(); free > now) return refuse(now, free, client, L1Stall::miss_queue_full);
    if (!turn_of(now, client)) return refuse(now, now + 1, client, L1Stall::miss_queue_full);
  }
  again_[client] = 0;
  now = take_bank(now, request, client);
  ++region.writes;
  ++counters_.responses;
  if (config_.perfect) {
    ++region.write_hits;
    return {now, now + config_.latency, true};
  }
  if (const SectorCacheTags::Slot slot = tags_.find(request.address); slot != SectorCacheTags::kNone) {
    tags_.touch(slot);
    const std::uint8_t sector = tags_.sector_bit(request.address);
    if ((tags_.valid(slot) & sector) != 0) {
      ++region.write_hits;
      reference(slot, sector);
    }
  }
  ++counters_.sent_writes;
  return {now, send(now, request).seen + 1, false};
}

void FastL1::drain() {
  while (!arrivals_.empty()) fill_next();
}

modules::L1Counters FastL1::counters() const {
  modules::L1Counters counters = counters_;
  counters.prefetches_unused += tags_.count_unused_prefetch();
  return counters;
}

}  // namespace grtx::tlm
