#include "rtl_tlm/fast/fast_l1.h"

#include <algorithm>
#include <bit>

namespace grtx::tlm {

using modules::L1Stall;
using modules::MemoryRequest;
using modules::SectorCacheTags;

FastL1::FastL1(const modules::L1Cache::Config& config, unsigned sm, std::size_t link_capacity, FastMemory& memory)
    : config_(config),
      sm_(static_cast<std::uint8_t>(sm)),
      memory_(memory),
      tags_(config.geometry),
      banks_(config.banks),
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

Cycle FastL1::room(Cycle now) {
  const Cycle crossed = crossed_[next_crossed_];
  if (crossed <= now + config_.tag_latency) return now;
  const Cycle at = crossed - config_.tag_latency;
  counters_.stalls[static_cast<std::size_t>(L1Stall::miss_queue_full)] += at - now;
  return at;
}

FastMemory::Trip FastL1::send(Cycle now, MemoryRequest request) {
  request.sm = sm_;
  const FastMemory::Trip trip = memory_.access(request, now + config_.tag_latency);
  crossed_[next_crossed_] = trip.crossed;
  next_crossed_ = next_crossed_ + 1 == crossed_.size() ? 0 : next_crossed_ + 1;
  return trip;
}

FastL1::Access FastL1::read(Cycle now, const MemoryRequest& request) {
  modules::L1Counters::ByRegion& region = counters_.region[static_cast<std::size_t>(request.region)];
  ++counters_.responses;
  if (request.prefetch) {
    ++counters_.prefetches;
  } else {
    ++region.reads;
  }
  if (config_.perfect) {
    ++(request.prefetch ? counters_.prefetches_redundant : region.hits);
    return {now, now + config_.latency, true};
  }
  fill(now);
  const SectorCacheTags::Slot slot = tags_.find(request.address);
  if (slot != SectorCacheTags::kNone) {
    const std::uint8_t sector = tags_.sector_bit(request.address);
    tags_.touch(slot);
    if ((tags_.valid(slot) & sector) != 0) {
      if (request.prefetch) {
        ++counters_.prefetches_redundant;
      } else {
        ++region.hits;
        reference(slot, sector);
      }
      return {now, now + config_.latency, true};
    }
  }
  const std::uint64_t number = request.address / modules::kSectorBytes;
  if (const std::uint32_t under_way = pending_.find(number); under_way != modules::AddressIndex::kNone) {
    Miss& miss = misses_[under_way];
    if (request.prefetch) {
      ++counters_.prefetches_redundant;
    } else {
      ++region.hits_on_miss;
      if (!miss.demanded) ++counters_.prefetches_late;
      miss.demanded = true;
    }
    return {now, std::max(now + config_.latency, miss.arrives + 1), false};
  }
  if (free_.empty()) {
    const Cycle free = std::max(now, arrivals_.next());
    counters_.stalls[static_cast<std::size_t>(L1Stall::mshr_full)] += free - now;
    now = free;
    fill_next();
  }
  now = room(now);
  const FastMemory::Trip trip = send(now, request);
  const DueWheel::Number miss = free_.back();
  free_.pop_back();
  misses_[miss] = {request.address, trip.seen, !request.prefetch};
  arrivals_.add(now, trip.seen, miss);
  pending_.insert(number, miss);
  ++counters_.sent_reads;
  counters_.miss_latency.add(trip.seen - now);
  counters_.mshr_cycles += trip.seen - now;
  ++(request.prefetch ? counters_.prefetches_fetched : region.misses);
  return {now, trip.seen + 1, false};
}

void FastL1::reference(SectorCacheTags::Slot slot, std::uint8_t sector) {
  if ((tags_.unused_prefetch(slot) & sector) == 0) return;
  tags_.clear_unused_prefetch(slot, sector);
  ++counters_.prefetches_useful;
}

FastL1::Access FastL1::write(Cycle now, const MemoryRequest& request) {
  modules::L1Counters::ByRegion& region = counters_.region[static_cast<std::size_t>(request.region)];
  ++region.writes;
  ++counters_.responses;
  if (config_.perfect) {
    ++region.write_hits;
    return {now, now + config_.latency, true};
  }
  fill(now);
  now = room(now);
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
