// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/cache/l2_slice.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <ostream>

#include "grtx/base/error.h"

namespace grtx::modules {
L2Slice::L2Slice(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock)
    : L2SliceModule(name, clock),
      dram("dram", clock),
      config_(config),
      tags_(config.geometry),
      written_by_(tags_.slots()),
      mshrs_(config.mshr_entries, config.mshr_merges),
      pipe_(std::size_t{config.latency} + config.queue) {
  const auto require = [](bool holds, const char* rule) {
    if (!holds) throw Error("configuration", "l2", rule);
  };
  config.interleave.check();
  require(config.slice < config.interleave.slices, "slice number must be below the number of slices");
  require(config.geometry.sector_bytes == kSectorBytes, "sectors must be 32 bytes, the size of a request");
  require_allowed("l2", config);
  if (config.keep_data) dram.keep_data();
  dram.set_base(config.base);
}

void L2Slice::end_of_elaboration() {
  in_ = reader_of(request);
  out_ = writer_of(response);
  in_.wake(&alarm_);
  dram.wake(&alarm_);
}

void L2Slice::restart(Caches caches) {
  dram.restart();
  tags_.restart(caches == Caches::warm);
  mshrs_ = MshrTable(config_.mshr_entries, config_.mshr_merges);
  pipe_.clear();
  replies_.clear();
  dram_queue_.clear();
  due_ = kNever;
  mshr_counted_ = 0;
  counters_ = {};
}

void L2Slice::save(StateWriter& state) const {
  assert(idle());
  tags_.save(state);
  save_regions(written_by_, state);
}

void L2Slice::load(StateReader& state) {
  tags_.load(state);
  load_regions(written_by_, state);
}

void L2Slice::preload(std::uint64_t address) { tags_.preload(config_.interleave.local(address), {.address = address}); }

inline bool L2Slice::work_at(Cycle now) const {
  return due_ <= now || in_.front(now) != nullptr || dram.front(now) != nullptr ||
         (!dram_queue_.empty() && dram.can_send(now));
}

Cycle L2Slice::tick(Cycle now) { return stages_ == nullptr ? work<false>(now) : work<true>(now); }

template <bool kObserved>
inline Cycle L2Slice::work(Cycle now) {
  dram.update(now);
  if (!work_at(now)) return std::min(due_, next_arrival());
  prefetch_host(now);
  if (in_.next_visible() <= now) take_request<kObserved>(now);
  take_completion(now);  // before the accesses, so that a sector filled in this cycle hits in this cycle
  if (!pipe_.empty() && pipe_.front().due <= now) look_up(now);
  if (!dram_queue_.empty()) send_dram(now);
  if (!replies_.empty()) send_reply<kObserved>(now);
  due_ = next_due(now);
  return std::min(due_, std::max(now + 1, next_arrival()));
}

template <bool kObserved>
inline void L2Slice::take_request(Cycle now) {
  const MemoryRequest* arrived = in_.front(now);
  if (arrived == nullptr || pipe_.size() >= std::size_t{config_.latency} + config_.queue) return;
  assert(config_.interleave.slice(arrived->address) == config_.slice);
  pipe_.push({*arrived, now + config_.latency});
  if (kObserved && !arrived->write) stages_->enters_l2(arrived->sm, arrived->tag, now);
  in_.pop(now);
  ++counters_.requests_in;
}

// Prefetches into the host's cache what this cycle's completion and the next access in the pipeline will read.
void L2Slice::prefetch_host(Cycle now) const {
  if (config_.perfect) return;
  if (const AtInitiator::Completion* completion = dram.front(now);
      completion != nullptr && completion->context != kWriteBack) {
    mshrs_.prefetch_entry(completion->context);
    mshrs_.prefetch_find(completion->address);
    tags_.prefetch(config_.interleave.local(completion->address));
  }
  if (pipe_.size() > 1 && pipe_.front().due <= now) {
    const std::uint64_t next = pipe_[1].request.address;
    tags_.prefetch(config_.interleave.local(next));
    mshrs_.prefetch_find(next);
  }
}

bool L2Slice::stall(L2Stall reason) {
  ++counters_.stalls[static_cast<std::size_t>(reason)];
  return false;
}

// The fill port: one completion per cycle.
void L2Slice::take_completion(Cycle now) {
  const AtInitiator::Completion* completion = dram.front(now);
  if (completion == nullptr) return;
  if (!completion->ok()) dram.report_refusal(*completion);
  if (completion->context != kWriteBack && !fill(now, completion->context)) {
    stall(L2Stall::fill);
    return;
  }
  dram.pop();
}

[[gnu::noinline]] bool L2Slice::fill(Cycle now, std::uint32_t mshr) {
  assert(mshrs_.in_use(mshr));
  const std::span<const MshrWaiter> waiters = mshrs_.waiters(mshr);
  if (replies_.size() + waiters.size() > config_.reply_queue) return false;
  const std::uint64_t address = mshrs_.sector_address(mshr);
  if (!install(mshrs_.first(mshr))) return false;
  for (const MshrWaiter& w : waiters) {
    replies_.push({address, w.tag, w.client, w.sm, w.region, w.write, w.prefetch});
    if (stages_ != nullptr) stages_->fills_l2(w.sm, w.tag, now);
  }
  counters_.miss_latency.add(now - mshrs_.allocated(mshr));
  count_mshr_cycles(now);
  mshrs_.release(mshr);
  return true;
}

bool L2Slice::install(const MemoryRequest& access) {
  const std::uint64_t local = config_.interleave.local(access.address);
  SectorCacheTags::Slot slot = tags_.find(local);
  if (slot == SectorCacheTags::kNone) {
    if (!room_for_victim(local, access)) return false;
    slot = allocate(local, access);
  }
  tags_.set_valid(slot, tags_.sector_bit(local));
  return true;
}

inline void L2Slice::look_up(Cycle now) {
  const MemoryRequest& head = pipe_.front().request;
  if (head.write ? write(head) : read(now, head)) pipe_.pop();
}

bool L2Slice::read(Cycle now, const MemoryRequest& access) {
  const std::uint64_t local = config_.interleave.local(access.address);
  const SectorCacheTags::Slot slot = config_.perfect ? SectorCacheTags::kNone : tags_.find(local);
  const bool present = slot != SectorCacheTags::kNone && (tags_.valid(slot) & tags_.sector_bit(local)) != 0;
  const bool hit = config_.perfect || present;
  RegionCounters& region = counters_.region[index(access.region)];
  if (hit) {
    if (replies_.size() >= config_.reply_queue) return stall(L2Stall::reply_queue);
    reply(access);
    ++region.hits;
  } else if (const std::uint32_t pending = mshrs_.find(access.address); pending != MshrTable::kNone) {
    if (mshrs_.merges_full(pending)) return stall(L2Stall::merges_full);
    mshrs_.merge(pending, access);
    ++region.hits_on_miss;
  } else {
    if (mshrs_.full()) return stall(L2Stall::mshr_full);
    if (dram_queue_.size() >= config_.dram_queue) return stall(L2Stall::dram_queue);
    count_mshr_cycles(now);
    dram_queue_.push({access.address, mshrs_.allocate(now, access.address, access), {access.sm, access.region}, false});
    ++region.misses;
  }
  ++region.reads;
  if (!hit && stages_ != nullptr) stages_->misses_l2(access.sm, access.tag, now);
  if (slot != SectorCacheTags::kNone) tags_.touch(slot, [&] { return access; });
  return true;
}

// A write covers its whole sector, so nothing is fetched. A pending fill of the same sector later changes nothing.
bool L2Slice::write(const MemoryRequest& access) {
  if (replies_.size() >= config_.reply_queue) return stall(L2Stall::reply_queue);
  RegionCounters& region = counters_.region[index(access.region)];
  if (config_.perfect) {
    ++region.write_hits;
  } else {
    const std::uint64_t local = config_.interleave.local(access.address);
    const std::uint8_t sector = tags_.sector_bit(local);
    SectorCacheTags::Slot slot = tags_.find(local);
    if (slot == SectorCacheTags::kNone) {
      if (!room_for_victim(local, access)) return stall(L2Stall::dram_queue);
      slot = allocate(local, access);
    } else {
      tags_.touch(slot, [&] { return access; });
    }
    if ((tags_.valid(slot) & sector) != 0) ++region.write_hits;
    tags_.set_valid(slot, sector);
    tags_.set_dirty(slot, sector);
    written_by_[slot] = access.region;
  }
  ++region.writes;
  reply(access);
  return true;
}

bool L2Slice::room_for_victim(std::uint64_t local, const MemoryRequest& access) const {
  const auto sectors = static_cast<std::size_t>(std::popcount(tags_.victim(local, access).dirty));
  return dram_queue_.size() + sectors <= config_.dram_queue;
}

SectorCacheTags::Slot L2Slice::allocate(std::uint64_t local, const MemoryRequest& access) {
  SectorCacheTags::Victim victim;
  const SectorCacheTags::Slot slot = tags_.insert(local, access, &victim);
  if (victim.valid) ++counters_.evictions;
  write_back(victim, written_by_[slot]);
  return slot;
}

void L2Slice::write_back(const SectorCacheTags::Victim& victim, Region region) {
  for (unsigned sector = 0; sector < config_.geometry.sectors(); ++sector) {
    if ((victim.dirty >> sector & 1) == 0) continue;
    const std::uint64_t evicted = victim.address + std::uint64_t{sector} * config_.geometry.sector_bytes;
    dram_queue_.push(
        {config_.interleave.global(evicted, config_.slice), kWriteBack, {RequestOrigin::kNobody, region}, true});
  }
}

inline void L2Slice::reply(const MemoryRequest& r) { replies_.push(response_to(r)); }

[[gnu::noinline]] void L2Slice::send_dram(Cycle now) {
  if (!dram.can_send(now)) return;
  const DramRequest head = dram_queue_.front();
  dram_queue_.pop();
  ++(head.write ? counters_.dram_writes : counters_.dram_reads);
  ++(head.write ? counters_.dram_writes_of : counters_.dram_reads_of)[index(head.origin.region)];
  dram.send(head.address, config_.geometry.sector_bytes, head.write, head.context, head.origin);
}

template <bool kObserved>
inline void L2Slice::send_reply(Cycle now) {
  if (!out_.try_push(now, replies_.front())) return;
  if (const MemoryResponse& sent = replies_.front(); kObserved && !sent.write) {
    stages_->leaves_l2(sent.sm, sent.tag, now);
  }
  replies_.pop();
  ++counters_.replies_out;
}

// First cycle in which a request or completion is visible, or the socket is free for a waiting DRAM request.
Cycle L2Slice::next_arrival() const {
  const Cycle next = std::min(in_.next_visible(), dram.next_visible());
  return dram_queue_.empty() ? next : std::min(next, dram.next_send());
}

// Ignores a busy socket: the end of its request phase wakes the slice.
Cycle L2Slice::next_due(Cycle now) const {
  const Cycle soon = now + 1;
  if (in_.front(now) != nullptr || !replies_.empty() || dram.front(now) != nullptr) return soon;
  if (!dram_queue_.empty() && dram.can_send(now)) return soon;
  return pipe_.empty() ? kNever : std::max(soon, pipe_.front().due);
}

void L2Slice::count_mshr_cycles(Cycle now) {
  counters_.mshr_cycles += mshrs_.used() * (now - mshr_counted_);
  mshr_counted_ = now;
}

bool L2Slice::idle() const {
  return pipe_.empty() && replies_.empty() && dram_queue_.empty() && mshrs_.used() == 0 && dram.idle() && in_.empty();
}

Inventory L2Slice::inventory() const {
  const unsigned request_bits = kAddressBits - 5 + 32 + 8 + 8 + 4 + 2;  // sector address, tag, client, SM, region, kind
  const unsigned waiter_bits = 32 + 8 + 8 + 4 + 1;
  const std::uint64_t lines = config_.geometry.sets() * config_.geometry.ways;
  const std::uint64_t sector_bits = std::uint64_t{8} * config_.geometry.sector_bytes;
  Inventory inventory;
  inventory.module = this->name();
  inventory.storage = {
      {"data", StorageKind::cache, lines * config_.geometry.line_bytes * 8, 1, 1, false, 256},
      {"tags", StorageKind::cache_tags, tags_.tag_bits(kAddressBits, true), 1, 1, false},
      {"mshr", StorageKind::flip_flop,
       std::uint64_t{config_.mshr_entries} * (kAddressBits - 5 + 1 + std::uint64_t{config_.mshr_merges} * waiter_bits),
       1, 1, false},
      {"queue", StorageKind::ram, std::uint64_t{config_.queue} * (request_bits + sector_bits), 1, 1, false},
      {"reply_queue", StorageKind::ram, std::uint64_t{config_.reply_queue} * (request_bits + sector_bits), 1, 1, false},
      {"dram_queue", StorageKind::ram, std::uint64_t{config_.dram_queue} * (kAddressBits - 5 + 9 + sector_bits), 1, 1,
       false}};
  inventory.operators = {{"match", kAddressBits - 7, config_.geometry.ways},
                         {"match", kAddressBits - 5, config_.mshr_entries}};
  return inventory;
}

void L2Slice::dump_state(std::ostream& out) const {
  out << name() << ": pipe " << pipe_.size() << ", replies " << replies_.size() << '/' << config_.reply_queue
      << ", dram queue " << dram_queue_.size() << '/' << config_.dram_queue << ", dram outstanding "
      << dram.outstanding() << ", mshr " << mshrs_.used() << '/' << config_.mshr_entries << '\n';
  if (!pipe_.empty()) {
    out << "  head: " << (pipe_.front().request.write ? "write" : "read") << " 0x" << std::hex
        << pipe_.front().request.address << std::dec << " due cycle " << pipe_.front().due << '\n';
  }
  mshrs_.dump_state(out);
}

void L2SliceModule::save(StateWriter& /*state*/) const { refuse_state(*this); }

void L2SliceModule::load(StateReader& /*state*/) { refuse_state(*this); }

std::unique_ptr<L2SliceModule> make_l2_slice(const sc_core::sc_module_name& name, const L2SliceConfig& config,
                                             ClockDomain& clock) {
  return std::make_unique<L2Slice>(name, config, clock);
}

}  // namespace grtx::modules
