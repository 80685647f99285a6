#include "rtl_tlm/fast/fast_memory.h"

#include <algorithm>
#include <bit>

namespace grtx::tlm {

using modules::kNever;
using modules::L2Stall;
using modules::MemoryRequest;
using modules::MemoryResponse;
using modules::MshrTable;
using modules::SectorCacheTags;

namespace {

MemoryResponse answer(const MemoryRequest& r) {
  return {r.address, r.tag, r.client, r.sm, r.region, r.write, r.prefetch};
}

}  // namespace

FastMemory::FastMemory(const GpuConfig& config, std::uint64_t bytes)
    : core_fs_(modules::ClockDomain::period_fs(config.core_mhz)),
      memory_fs_(modules::ClockDomain::period_fs(config.memory_mhz)),
      link_(config.links.latency),
      latency_(config.links.latency + config.crossbar.latency),
      pipe_(config.l2.latency),
      capacity_(config.l2.latency + config.l2.queue + config.crossbar.latency + config.crossbar.output_buffer),
      interleave_(config.interleave),
      dram_(config.dram_config(bytes)),
      sector_bytes_(config.l2.geometry.sector_bytes),
      inputs_(config.sms),
      l2_(config.interleave.slices),
      ports_(config.sms) {
  for (unsigned i = 0; i < config.interleave.slices; ++i) slices_.emplace_back(config.l2_slice(i), dram_.channel);
}

void FastMemory::send(const MemoryRequest& request, Cycle sent) {
  inputs_[request.sm].requests.push({request, sent + link_});
}

Cycle FastMemory::next_of(const Slice& slice) const {
  Cycle next = slice.fills.empty() ? kNever : slice.fills.front().due;
  if (!slice.pipe.empty() && slice.lookup_next != kNever) {
    next = std::min(next, std::max(slice.pipe.front().at, slice.lookup_next));
  }
  return next;
}

Cycle FastMemory::next_due() const {
  Cycle due = kNever;
  for (const Slice& slice : slices_) {
    due = std::min(due, next_of(slice));
    // The DRAM is looked at in every step while it has work: its queue refills the slice.
    if (slice.outstanding != 0 || !slice.to_dram.empty()) return 0;
  }
  for (const Port& port : ports_) {
    if (!port.waiting.empty()) return 0;
  }
  for (const Input& input : inputs_) {
    if (!input.requests.empty()) return 0;
  }
  return due == kNever ? kNever : due > latency_ + pipe_ ? due - latency_ - pipe_ : 0;
}

bool FastMemory::idle() const {
  return std::all_of(slices_.begin(), slices_.end(),
                     [](const Slice& s) {
                       return s.pipe.empty() && s.fills.empty() && s.to_dram.empty() && s.outstanding == 0 &&
                              s.mshrs.used() == 0;
                     }) &&
         std::all_of(ports_.begin(), ports_.end(),
                     [](const Port& p) { return p.waiting.empty() && p.replies.empty(); }) &&
         std::all_of(inputs_.begin(), inputs_.end(), [](const Input& i) { return i.requests.empty(); });
}

// The tags of a slice see a request `latency_ + pipe_` cycles after it was sent, so the slices can run ahead of the SMs
// by as much. A slice and its DRAM channel take short turns: what blocks the one is freed by the other.
void FastMemory::run(Cycle end) {
  constexpr Cycle kTurn = 16;
  const Cycle known = end + latency_ + pipe_;
  cross(end + link_);
  for (unsigned i = 0; i < slices_.size(); ++i) {
    for (Cycle begin = now_; begin < known;) {
      if (slices_[i].outstanding == 0 && slices_[i].to_dram.empty()) begin = std::max(begin, next_of(slices_[i]));
      if (begin >= known) break;
      const Cycle turn_end = std::min(begin + kTurn, known);
      run_slice(i, begin, turn_end);
      run_dram(slices_[i], turn_end);
      begin = turn_end;
    }
  }
  now_ = known;
  deliver(known);
}

// Crosses what the crossbar sees before `end`. An output takes one request a cycle, an input gives up its oldest only:
// one that waits for a busy slice holds back those behind it.
void FastMemory::cross(Cycle end) {
  for (;;) {
    const unsigned n = static_cast<unsigned>(inputs_.size());
    unsigned best = n;
    Cycle best_at = end;
    for (unsigned k = 0; k < n; ++k) {
      const unsigned i = first_input_ + k < n ? first_input_ + k : first_input_ + k - n;
      const Input& input = inputs_[i];
      if (input.requests.empty()) continue;
      const Arrival& head = input.requests.front();
      const Slice& slice = slices_[interleave_.slice(head.request.address)];
      if (slice.pipe.size() >= capacity_) continue;  // until the slice has run on
      const Cycle at = std::max({head.at, input.free, slice.input_free});
      if (at < best_at) {
        best = i;
        best_at = at;
      }
    }
    if (best == n) break;
    Input& input = inputs_[best];
    const MemoryRequest request = input.requests.front().request;
    input.requests.pop();
    input.free = best_at + 1;
    const unsigned index = interleave_.slice(request.address);
    Slice& slice = slices_[index];
    slice.input_free = best_at + 1;
    slice.pipe.push({request, best_at + latency_ - link_ + pipe_});
    ++l2_[index].requests_in;
    first_input_ = best + 1 == n ? 0 : best + 1;
  }
  // Nothing crosses in the past: what a full slice has held back goes on from here.
  for (Input& input : inputs_) {
    if (!input.requests.empty()) input.free = std::max(input.free, end);
  }
}

void FastMemory::run_slice(unsigned index, Cycle begin, Cycle end) {
  Slice& slice = slices_[index];
  if (slice.waits_for_dram) {
    slice.waits_for_dram = false;
    slice.lookup_next = begin;
  }
  for (Cycle now = next_of(slice); now < end; now = next_of(slice)) {
    if (!slice.fills.empty() && slice.fills.front().due <= now) {
      if (fill(index, now, slice.fills.front())) {
        slice.fills.pop();
        if (slice.lookup_next == kNever) slice.lookup_next = now;
      } else {
        ++l2_[index].stalls[static_cast<std::size_t>(L2Stall::fill)];
        slice.fills.front().due = now + 1;
      }
    }
    if (!slice.pipe.empty() && slice.pipe.front().at <= now && slice.lookup_next <= now) look_up(index, now);
    if (!slice.fills.empty()) slice.fills.front().due = std::max(slice.fills.front().due, now + 1);  // one a cycle
  }
}

bool FastMemory::fill(unsigned index, Cycle now, const Fill& done) {
  Slice& slice = slices_[index];
  if (done.context == kWriteBack) return true;
  const std::uint64_t local = interleave_.local(done.address);
  SectorCacheTags::Slot slot = slice.tags.find(local);
  if (slot == SectorCacheTags::kNone) {
    if (!room_for_victim(slice, local)) return false;
    slot = allocate(index, now, local);
  }
  slice.tags.set_valid(slot, slice.tags.sector_bit(local));
  for (const modules::MshrWaiter& w : slice.mshrs.waiters(done.context)) {
    reply(index, now, {done.address, w.tag, w.client, w.sm, w.region, w.write, w.prefetch});
  }
  l2_[index].miss_latency.add(now - slice.mshrs.allocated(done.context));
  count_mshr_cycles(index, now);
  slice.mshrs.release(done.context);
  return true;
}

void FastMemory::look_up(unsigned index, Cycle now) {
  Slice& slice = slices_[index];
  const MemoryRequest access = slice.pipe.front().request;
  if (access.write ? write(index, now, access) : read(index, now, access)) {
    slice.pipe.pop();
    slice.lookup_next = now + 1;
  }
}

bool FastMemory::read(unsigned index, Cycle now, const MemoryRequest& access) {
  Slice& slice = slices_[index];
  modules::L2Counters& counters = l2_[index];
  const auto stall = [&](L2Stall reason) {
    ++counters.stalls[static_cast<std::size_t>(reason)];
    slice.waits_for_dram = reason == L2Stall::dram_queue;
    slice.lookup_next = kNever;
    return false;
  };
  const std::uint64_t local = interleave_.local(access.address);
  const bool perfect = slice.config.perfect;
  const SectorCacheTags::Slot slot = perfect ? SectorCacheTags::kNone : slice.tags.find(local);
  const bool hit =
      perfect || (slot != SectorCacheTags::kNone && (slice.tags.valid(slot) & slice.tags.sector_bit(local)));
  modules::L2Counters::ByRegion& region = counters.region[static_cast<std::size_t>(access.region)];
  if (hit) {
    reply(index, now, answer(access));
    ++region.hits;
  } else if (const std::uint32_t pending = slice.mshrs.find(access.address); pending != MshrTable::kNone) {
    if (slice.mshrs.merges_full(pending)) return stall(L2Stall::merges_full);
    slice.mshrs.merge(pending, access);
    ++region.hits_on_miss;
  } else {
    if (slice.mshrs.full()) return stall(L2Stall::mshr_full);
    if (slice.to_dram.size() >= slice.config.dram_queue) return stall(L2Stall::dram_queue);
    count_mshr_cycles(index, now);
    ask_dram(index, now, access.address, slice.mshrs.allocate(now, access.address, access), false);
    ++region.misses;
  }
  ++region.reads;
  if (slot != SectorCacheTags::kNone) slice.tags.touch(slot);
  return true;
}

bool FastMemory::write(unsigned index, Cycle now, const MemoryRequest& access) {
  Slice& slice = slices_[index];
  modules::L2Counters::ByRegion& region = l2_[index].region[static_cast<std::size_t>(access.region)];
  if (slice.config.perfect) {
    ++region.write_hits;
  } else {
    const std::uint64_t local = interleave_.local(access.address);
    const std::uint8_t sector = slice.tags.sector_bit(local);
    SectorCacheTags::Slot slot = slice.tags.find(local);
    if (slot == SectorCacheTags::kNone) {
      if (!room_for_victim(slice, local)) {
        ++l2_[index].stalls[static_cast<std::size_t>(L2Stall::dram_queue)];
        slice.waits_for_dram = true;
        slice.lookup_next = kNever;
        return false;
      }
      slot = allocate(index, now, local);
    } else {
      slice.tags.touch(slot);
    }
    if ((slice.tags.valid(slot) & sector) != 0) ++region.write_hits;
    slice.tags.set_valid(slot, sector);
    slice.tags.set_dirty(slot, sector);
  }
  ++region.writes;
  reply(index, now, answer(access));
  return true;
}

bool FastMemory::room_for_victim(const Slice& slice, std::uint64_t local) const {
  const auto sectors = static_cast<std::size_t>(std::popcount(slice.tags.victim(local).dirty));
  return slice.to_dram.size() + sectors <= slice.config.dram_queue;
}

SectorCacheTags::Slot FastMemory::allocate(unsigned index, Cycle now, std::uint64_t local) {
  Slice& slice = slices_[index];
  SectorCacheTags::Victim victim;
  const SectorCacheTags::Slot slot = slice.tags.insert(local, &victim);
  if (victim.valid) ++l2_[index].evictions;
  for (unsigned sector = 0; sector < slice.config.geometry.sectors(); ++sector) {
    if ((victim.dirty >> sector & 1) == 0) continue;
    const std::uint64_t evicted = victim.address + std::uint64_t{sector} * sector_bytes_;
    ask_dram(index, now, interleave_.global(evicted, index), kWriteBack, true);
  }
  return slot;
}

void FastMemory::ask_dram(unsigned index, Cycle now, std::uint64_t address, std::uint32_t context, bool write) {
  Slice& slice = slices_[index];
  const Cycle sent = std::max(now, slice.send_free);
  slice.send_free = sent + 1;
  slice.to_dram.push({address, context, write, sent});
  ++(write ? l2_[index].dram_writes : l2_[index].dram_reads);
}

// The memory clock of core cycle c's edge is the first strictly after it, and the other way round (AtInitiator, Dram).
void FastMemory::run_dram(Slice& slice, Cycle end) {
  const Cycle limit = end * core_fs_ / memory_fs_;
  const auto after_memory = [this](Cycle clock) { return clock * memory_fs_ / core_fs_ + 1; };
  const auto after_core = [this](Cycle cycle) { return cycle * core_fs_ / memory_fs_ + 1; };
  for (; !slice.to_dram.empty(); slice.to_dram.pop()) {
    const DramRequest& request = slice.to_dram.front();
    Cycle clock = std::max(after_core(request.sent), slice.arrival_free);
    if (clock > limit) break;
    // The request and its address, packed: 24 bits of MSHR number (FastGpu checks it) below 40 of sector number.
    const std::uint64_t id = request.address / sector_bytes_ << 24 | (request.context & 0xFFFFFF);
    if (dram_.perfect) {
      slice.dram.count_unqueued(sector_bytes_, request.write);
      slice.fills.push({request.context, request.address, after_memory(clock + dram_.fixed_latency)});
      ++responses_;
      slice.arrival_free = after_core(after_memory(clock));
      continue;
    }
    slice.dram.run_until(clock - 1);
    if (!slice.dram.can_accept(sector_bytes_)) {
      const Cycle room = slice.dram.run_until_room(sector_bytes_) + 1;
      if (room > clock) full_clocks_ += room - clock;
      clock = std::max(clock, room);
    }
    slice.dram.enqueue(clock, id, interleave_.local(request.address), sector_bytes_, request.write);
    slice.arrival_free = after_core(after_memory(clock));
    ++slice.outstanding;
  }
  slice.dram.run_until(limit);
  for (auto& done = slice.dram.completions(); !done.empty(); done.pop()) {
    const Cycle clock = std::max(done.front().done + dram_.fixed_latency, slice.response_free);
    slice.response_free = (clock * memory_fs_ + core_fs_) / memory_fs_ + 1;
    const std::uint64_t address = (done.front().id >> 24) * sector_bytes_;
    const auto context = static_cast<std::uint32_t>(done.front().id & 0xFFFFFF);
    slice.fills.push({context == 0xFFFFFF ? kWriteBack : context, address, after_memory(clock)});
    --slice.outstanding;
    ++responses_;
  }
}

// A slice sends one reply a cycle.
void FastMemory::reply(unsigned index, Cycle now, const MemoryResponse& response) {
  Slice& slice = slices_[index];
  const Cycle sent = std::max(now, slice.reply_free);
  slice.reply_free = sent + 1;
  ports_[response.sm].waiting.push_back({response, sent + latency_});
  ++l2_[index].replies_out;
  ++packets_;
}

// What no later answer can overtake takes its turn at the SM's port, one a cycle.
void FastMemory::deliver(Cycle end) {
  for (Port& port : ports_) {
    if (port.waiting.empty()) continue;
    std::sort(port.waiting.begin(), port.waiting.end(), [](const Reply& a, const Reply& b) {
      return a.due != b.due ? a.due < b.due : a.response.address < b.response.address;
    });
    std::size_t taken = 0;
    for (; taken < port.waiting.size() && port.waiting[taken].due < end + latency_; ++taken) {
      Reply reply = port.waiting[taken];
      reply.due = std::max(reply.due, port.free);
      port.free = reply.due + 1;
      port.replies.push(reply);
    }
    port.waiting.erase(port.waiting.begin(), port.waiting.begin() + static_cast<std::ptrdiff_t>(taken));
  }
}

void FastMemory::count_mshr_cycles(unsigned index, Cycle now) {
  Slice& slice = slices_[index];
  l2_[index].mshr_cycles += slice.mshrs.used() * (now - slice.mshr_counted);
  slice.mshr_counted = now;
}

std::vector<modules::DramChannelCounters> FastMemory::channels() const {
  std::vector<modules::DramChannelCounters> all;
  for (const Slice& slice : slices_) all.push_back(slice.dram.counters());
  return all;
}

modules::DramCounters FastMemory::dram(Cycle end) const {
  modules::DramCounters sum;
  for (const Slice& slice : slices_) sum.channel += slice.dram.counters();
  sum.responses = responses_;
  sum.full_clocks = full_clocks_;
  sum.clocks = end * core_fs_ / memory_fs_;
  const double peak = static_cast<double>(slices_.size()) * dram_.channel.burst_bytes / dram_.channel.timing.ccd;
  if (sum.clocks > 0) {
    sum.bandwidth_utilisation = static_cast<double>(sum.channel.bytes) / (peak * static_cast<double>(sum.clocks));
  }
  return sum;
}

std::uint64_t FastMemory::dirty_sectors() const {
  std::uint64_t sum = 0;
  for (const Slice& slice : slices_) sum += slice.tags.count_dirty();
  return sum;
}

}  // namespace grtx::tlm
