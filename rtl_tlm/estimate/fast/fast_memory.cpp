#include "grtx/rtl_tlm/estimate/fast/fast_memory.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "grtx/modules/cache/cache_state.h"

namespace grtx::sim {

using modules::L2Stall;
using modules::load_regions;
using modules::save_regions;
using modules::SectorCacheTags;

namespace {

unsigned count_of(std::uint8_t sectors) { return static_cast<unsigned>(std::popcount(sectors)); }

}  // namespace

FastMemory::FastMemory(const GpuConfig& config, std::uint64_t bytes)
    : core_fs_(modules::ClockDomain::period_fs(config.core_mhz)),
      memory_fs_(modules::ClockDomain::period_fs(config.memory_mhz)),
      clocks_a_cycle_(static_cast<double>(core_fs_) / static_cast<double>(memory_fs_)),
      gap_(config.links.capacity == 1 ? 2 : 1),
      link_(config.links.latency),
      latency_(config.links.latency + config.crossbar.latency),
      pipe_(config.l2.latency),
      interleave_(config.interleave),
      dram_(config.dram_config(bytes)),
      perfect_(config.l2.perfect),
      sector_bytes_(config.l2.geometry.sector_bytes),
      inputs_(config.sms),
      replies_(config.sms),
      l2_(config.interleave.slices) {
  const std::size_t capacity =
      config.l2.latency + config.l2.queue + config.crossbar.latency + config.crossbar.output_buffer;
  // A response holds its way for a core period; the next begins in the first memory clock after that.
  const auto response = static_cast<unsigned>(core_fs_ / memory_fs_ + 1);
  for (unsigned i = 0; i < config.interleave.slices; ++i) {
    slices_.emplace_back(config.l2_slice(i), capacity, response);
  }
  for (unsigned i = 0; i < interleave_.dram_channels(); ++i) dram_channels_.emplace_back(dram_.channel);
}

void FastMemory::keep(FastMemory& before) {
  for (std::size_t i = 0; i < slices_.size(); ++i) {
    slices_[i].tags = std::move(before.slices_[i].tags);
    slices_[i].tags.restart(true);
    slices_[i].written_by = std::move(before.slices_[i].written_by);
  }
  for (std::size_t i = 0; i < dram_channels_.size(); ++i) dram_channels_[i].keep_rows(before.dram_channels_[i]);
}

void FastMemory::save(StateWriter& state) const {
  for (const Slice& slice : slices_) {
    slice.tags.save(state);
    save_regions(slice.written_by, state);
  }
  for (const FastDramChannel& channel : dram_channels_) channel.save(state);
}

void FastMemory::load(StateReader& state) {
  for (Slice& slice : slices_) {
    slice.tags.load(state);
    load_regions(slice.written_by, state);
  }
  for (FastDramChannel& channel : dram_channels_) channel.load(state);
}

FastMemory::Trip FastMemory::access(const Request& request, Cycle sent) {
  const unsigned index = interleave_.slice(request.line);
  Slice& slice = slices_[index];
  const unsigned count = count_of(request.sectors);
  l2_[index].requests_in += count;
  l2_[index].replies_out += count;
  // An SM's oldest request holds back those behind it; a slice takes one a cycle, as long as it has room.
  Cycle& input = inputs_[request.sm];
  Cycle now = 0;
  for (unsigned i = 0; i < count; ++i) {
    // What others have sent already crosses later than they were told; so does what they send next.
    const Cycle crossed = slice.input.reserve(std::max({sent + link_, input, slice.looked_up.room()}), request.sm,
                                              [this](unsigned other) { ++inputs_[other]; });
    input = crossed + gap_;
    now = crossed + latency_ - link_ + pipe_;  // in turn, as they crossed, unless the slice stood still
    if (slice.blocked_until > now) now = slice.lookup.reserve(slice.blocked_until);
    slice.looked_up.take(now);
  }
  Trip trip{input, 0};
  const Cycle done = look_up(index, request, now);
  const Cycle first = done - (count - 1);
  PortCalendar& replies = replies_[request.sm];
  if (slice.reply.reserve_run(first, count)) {
    if (replies.reserve_run(first + latency_, count)) {
      trip.seen = done + latency_;
    } else {
      for (unsigned i = 0; i < count; ++i) trip.seen = std::max(trip.seen, replies.reserve(first + i + latency_));
    }
    return trip;
  }
  for (unsigned i = 0; i < count; ++i) {
    trip.seen = std::max(trip.seen, replies.reserve(slice.reply.reserve(first + i) + latency_));
  }
  return trip;
}

SectorCacheTags::Slot FastMemory::find_or_insert(Slice& slice, std::uint64_t local, SectorCacheTags::Victim& victim) {
  const SectorCacheTags::Slot slot = slice.tags.find(local);
  if (slot == SectorCacheTags::kNone) return slice.tags.insert(local, &victim);
  slice.tags.touch(slot);
  return slot;
}

void FastMemory::warm(const Request& request) {
  if (perfect_) return;
  Slice& slice = slices_[interleave_.slice(request.line)];
  SectorCacheTags::Victim victim;
  const SectorCacheTags::Slot slot = find_or_insert(slice, interleave_.local(request.line), victim);
  slice.tags.set_valid(slot, request.sectors);
  slice.arrivals.are_there(slot, request.sectors);
  if (!request.write) return;
  slice.tags.set_dirty(slot, request.sectors);
  slice.written_by[slot] = request.region;
}

// When the last answer is there.
Cycle FastMemory::look_up(unsigned index, const Request& request, Cycle now) {
  Slice& slice = slices_[index];
  modules::L2Counters& counters = l2_[index];
  modules::RegionCounters& region = counters.region[static_cast<std::size_t>(request.region)];
  const unsigned count = count_of(request.sectors);
  (request.write ? region.writes : region.reads) += count;
  if (perfect_) {
    (request.write ? region.write_hits : region.hits) += count;
    return now;
  }
  const std::uint64_t local = interleave_.local(request.line);
  SectorCacheTags::Victim victim;
  const SectorCacheTags::Slot slot = find_or_insert(slice, local, victim);
  const modules::Region written_by = slice.written_by[slot];  // the line's place is the victim's
  if (victim.valid) ++counters.evictions;
  const auto present = static_cast<std::uint8_t>(request.sectors & slice.tags.valid(slot));
  slice.tags.set_valid(slot, request.sectors);
  if (request.write) {
    slice.arrivals.are_there(slot, request.sectors);
    region.write_hits += count_of(present);
    slice.tags.set_dirty(slot, request.sectors);
    slice.written_by[slot] = request.region;
    write_back(index, now, victim, written_by);
    return now;
  }
  Cycle last = now;
  const unsigned late = slice.arrivals.count_late(slot, present, now, last);
  region.hits_on_miss += late;
  region.hits += count_of(present) - late;
  const auto missing = static_cast<std::uint8_t>(request.sectors & ~present);
  if (missing == 0) return last;
  const unsigned misses = count_of(missing);
  region.misses += misses;
  counters.dram_reads += misses;
  counters.dram_reads_of[modules::index(request.region)] += misses;
  unsigned behind = misses;
  for (std::uint8_t rest = missing; rest != 0; rest = static_cast<std::uint8_t>(rest & (rest - 1))) {
    const auto sector = static_cast<std::size_t>(std::countr_zero(rest));
    const Cycle looked_up = now - std::min<Cycle>(now, --behind);  // one a cycle
    const Cycle done = read_dram(index, looked_up, local + sector * sector_bytes_);
    counters.mshr_cycles += done - looked_up;
    counters.miss_latency.add(done - looked_up);
    slice.arrivals.come(slot, static_cast<unsigned>(sector), done);
    last = std::max(last, done);
  }
  write_back(index, last, victim, written_by);  // the line's place is taken when it comes
  return last;
}

void FastMemory::write_back(unsigned index, Cycle now, const SectorCacheTags::Victim& victim, modules::Region region) {
  if (victim.dirty == 0) return;
  l2_[index].dram_writes_of[modules::index(region)] += count_of(victim.dirty);
  l2_[index].dram_writes += count_of(victim.dirty);
  slices_[index].writes.push({clock_of(now), interleave_.in_channel(victim.address, index), count_of(victim.dirty)});
}

void FastMemory::write_dram(unsigned channel, Cycle clock) {
  FastDramChannel& dram = dram_channels_[channel];
  for (unsigned index = channel; index < slices_.size(); index += interleave_.dram_channels()) {
    modules::RingQueue<Write>& writes = slices_[index].writes;
    while (!writes.empty() && writes.front().clock <= clock) {
      const Write& write = writes.front();
      if (dram_.perfect) {
        dram.count_unqueued(write.sectors, sector_bytes_, true);
        respond(slices_[index], write.clock, write.sectors);
      } else {
        const Cycle done = dram.request(write.clock, write.address, write.sectors, sector_bytes_, true);
        respond(slices_[index], done, write.sectors);
      }
      writes.pop();
    }
  }
}

void FastMemory::finish() {
  for (unsigned channel = 0; channel < dram_channels_.size(); ++channel) write_dram(channel, modules::kNever);
}

Cycle FastMemory::read_dram(unsigned index, Cycle now, std::uint64_t local) {
  Slice& slice = slices_[index];
  const unsigned channel = interleave_.channel(index);
  FastDramChannel& dram = dram_channels_[channel];
  const Cycle clock = clock_of(now);
  write_dram(channel, clock);
  if (dram_.perfect) {
    dram.count_unqueued(1, sector_bytes_, false);
    return cycle_of(respond(slice, clock, 1));
  }
  const Cycle enters = dram.room(clock);  // the channel's own queue
  const std::uint64_t address = interleave_.in_channel(local, index);
  const Cycle done = cycle_of(respond(slice, dram.request(enters, address, 1, sector_bytes_, false), 1));
  slice.mshrs.take(done);
  if (enters > clock) slice.queue.take(enters);
  // A slice's misses reach the DRAM in the order in which they are made, and wait while a queue before it is full.
  const bool full = slice.queue.full(clock) || slice.mshrs.full(now);
  const Cycle blocked = std::max(slice.blocked_until, now);
  const Cycle queues = slice.queue.room(clock);
  slice.blocked_until = std::max({blocked, queues > clock ? cycle_of(queues) : 0, slice.mshrs.room(now)});
  if (full) l2_[index].stalls[static_cast<std::size_t>(L2Stall::dram_queue)] += slice.blocked_until - blocked;
  return done;
}

Cycle FastMemory::respond(Slice& slice, Cycle done, unsigned sectors) {
  const Cycle burst = dram_.perfect ? 0 : dram_.channel.timing.ccd;
  Cycle begins = 0;
  for (unsigned behind = sectors; behind-- > 0;) {
    const Cycle data = done - std::min<Cycle>(done, behind * burst);
    begins = std::max(begins, slice.responses.reserve(data + dram_.fixed_latency));
  }
  return begins;
}

void FastMemory::advance(Cycle now) {
  const Cycle clock = clock_of(now);
  for (unsigned channel = 0; channel < dram_channels_.size(); ++channel) write_dram(channel, clock);
  for (PortCalendar& port : replies_) port.advance(now);
  for (Slice& slice : slices_) {
    slice.input.advance(now);
    slice.lookup.advance(now);
    slice.reply.advance(now);
    slice.responses.advance(clock);
    slice.arrivals.advance(now);
  }
  for (FastDramChannel& dram : dram_channels_) dram.advance(clock);
}

std::vector<modules::DramChannelCounters> FastMemory::channels() const {
  std::vector<modules::DramChannelCounters> all;
  for (const FastDramChannel& dram : dram_channels_) all.push_back(dram.counters());
  return all;
}

std::vector<modules::DramChannelCounters> FastMemory::channels_by(Cycle end) const {
  std::vector<modules::DramChannelCounters> all = channels();
  for (std::size_t i = 0; i < all.size(); ++i) all[i].bursts = dram_channels_[i].bursts_by(clock_of(end));
  return all;
}

modules::DramCounters FastMemory::dram(const std::vector<modules::DramChannelCounters>& channels, Cycle end) const {
  modules::DramCounters sum = modules::dram_counters(dram_.channel, channels, end * core_fs_ / memory_fs_);
  sum.channel.responses = sum.channel.reads + sum.channel.writes;
  return sum;
}

std::uint64_t FastMemory::dirty_sectors() const {
  std::uint64_t sum = 0;
  for (const Slice& slice : slices_) sum += slice.tags.count_dirty();
  return sum;
}

}  // namespace grtx::sim
