#include "rtl_tlm/fast/fast_l1.h"

#include <algorithm>
#include <bit>

namespace grtx::tlm {

using modules::L1Stall;
using modules::MemoryRequest;
using modules::MemoryResponse;
using modules::MshrTable;
using modules::SectorCacheTags;

FastL1::FastL1(const modules::L1Cache::Config& config, unsigned sm, std::size_t link_capacity, FastMemory& memory)
    : config_(config),
      sm_(static_cast<std::uint8_t>(sm)),
      waiting_(config.miss_queue + link_capacity),
      memory_(memory),
      tags_(config.geometry),
      mshrs_(config.mshr_entries, config.mshr_merges) {}

FastL1::Outcome FastL1::access(Cycle now, MemoryRequest request) {
  if (banks_cycle_ != now) {
    banks_cycle_ = now;
    banks_taken_ = 0;
  }
  const std::uint64_t bank = std::uint64_t{1} << (request.address / modules::kSectorBytes % config_.banks);
  if ((banks_taken_ & bank) != 0) {
    ++counters_.stalls[static_cast<std::size_t>(L1Stall::bank_conflict)];
    return Outcome::conflict;
  }
  request.sm = sm_;
  const Outcome outcome = request.write ? write(now, request) : read(now, request);
  if (outcome != Outcome::refused) banks_taken_ |= bank;
  return outcome;
}

FastL1::Outcome FastL1::refuse(L1Stall reason, Cycle retry_at) {
  ++counters_.stalls[static_cast<std::size_t>(reason)];
  retry_at_ = retry_at;
  return Outcome::refused;
}

FastL1::Outcome FastL1::read(Cycle now, const MemoryRequest& request) {
  const SectorCacheTags::Slot slot = config_.perfect ? SectorCacheTags::kNone : tags_.find(request.address);
  const std::uint8_t sector = tags_.sector_bit(request.address);
  const bool hit = config_.perfect || (slot != SectorCacheTags::kNone && (tags_.valid(slot) & sector) != 0);
  const std::uint32_t pending = hit ? MshrTable::kNone : mshrs_.find(request.address);
  const bool miss = !hit && pending == MshrTable::kNone;
  if (miss) {
    if (mshrs_.full()) return refuse(L1Stall::mshr_full, modules::kNever);
    if (miss_queue_full(now)) return refuse(L1Stall::miss_queue_full, send_free_ + 1 - config_.tag_latency - waiting_);
  } else if (!hit && mshrs_.merges_full(pending)) {
    return refuse(L1Stall::merges_full, modules::kNever);
  }
  if (slot != SectorCacheTags::kNone) tags_.touch(slot);
  if (hit) {
    ++counters_.responses;
  } else if (!miss) {
    if (!request.prefetch && !mshrs_.demanded(pending)) ++counters_.prefetches_late;
    mshrs_.merge(pending, request);
  } else {
    count_mshr_cycles(now);
    MemoryRequest down = request;
    down.tag = mshrs_.allocate(now, request.address, request);
    send(now, down);
    ++counters_.sent_reads;
  }
  if (request.prefetch) {
    ++counters_.prefetches;
    ++(miss ? counters_.prefetches_fetched : counters_.prefetches_redundant);
  } else {
    modules::L1Counters::ByRegion& region = counters_.region[static_cast<std::size_t>(request.region)];
    ++region.reads;
    ++(hit ? region.hits : miss ? region.misses : region.hits_on_miss);
    if (hit && slot != SectorCacheTags::kNone) reference(slot, sector);
  }
  return hit ? Outcome::hit : Outcome::pending;
}

FastL1::Outcome FastL1::write(Cycle now, const MemoryRequest& request) {
  modules::L1Counters::ByRegion& region = counters_.region[static_cast<std::size_t>(request.region)];
  if (config_.perfect) {
    ++region.writes;
    ++region.write_hits;
    ++counters_.responses;
    return Outcome::hit;
  }
  if (miss_queue_full(now)) return refuse(L1Stall::miss_queue_full, send_free_ + 1 - config_.tag_latency - waiting_);
  const SectorCacheTags::Slot slot = tags_.find(request.address);
  const std::uint8_t sector = tags_.sector_bit(request.address);
  ++region.writes;
  if (slot != SectorCacheTags::kNone) {
    tags_.touch(slot);
    if ((tags_.valid(slot) & sector) != 0) {
      ++region.write_hits;
      reference(slot, sector);
    }
  }
  send(now, request);
  ++counters_.sent_writes;
  ++writes_pending_;
  return Outcome::pending;
}

void FastL1::send(Cycle now, const MemoryRequest& request) {
  const Cycle sent = std::max(now + config_.tag_latency, send_free_);
  send_free_ = sent + 1;
  memory_.send(request, sent);
}

void FastL1::store(Cycle now, const MemoryResponse& reply) {
  SectorCacheTags::Slot slot = tags_.find(reply.address);
  if (slot == SectorCacheTags::kNone) {
    SectorCacheTags::Victim victim;
    slot = tags_.insert(reply.address, &victim);
    if (victim.valid) ++counters_.evictions;
    counters_.prefetches_unused += static_cast<std::uint64_t>(std::popcount(victim.unused_prefetch));
  }
  const std::uint8_t sector = tags_.sector_bit(reply.address);
  tags_.set_valid(slot, sector);
  if (!mshrs_.demanded(reply.tag)) tags_.set_unused_prefetch(slot, sector);
  ++counters_.fills;
  counters_.miss_latency.add(now - mshrs_.allocated(reply.tag));
  count_mshr_cycles(now);
}

void FastL1::reference(SectorCacheTags::Slot slot, std::uint8_t sector) {
  if ((tags_.unused_prefetch(slot) & sector) == 0) return;
  tags_.clear_unused_prefetch(slot, sector);
  ++counters_.prefetches_useful;
}

void FastL1::count_mshr_cycles(Cycle now) {
  counters_.mshr_cycles += mshrs_.used() * (now - mshr_counted_);
  mshr_counted_ = now;
}

modules::L1Counters FastL1::counters() const {
  modules::L1Counters counters = counters_;
  counters.prefetches_unused += tags_.count_unused_prefetch();
  return counters;
}

}  // namespace grtx::tlm
