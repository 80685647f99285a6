#include "rtl_tlm/fast/fast_memory.h"

#include <algorithm>
#include <bit>

namespace grtx::tlm {

using modules::kNever;
using modules::L2Stall;
using modules::MemoryRequest;
using modules::SectorCacheTags;

namespace {

constexpr unsigned kFoundBits = 16;
constexpr std::int64_t kWeight = 256;  // intervals in the running mean
constexpr std::size_t kBusy = 16;      // requests from which on the DRAM's pace counts as its capacity

}  // namespace

FastMemory::FastMemory(const GpuConfig& config, std::uint64_t bytes)
    : core_fs_(modules::ClockDomain::period_fs(config.core_mhz)),
      memory_fs_(modules::ClockDomain::period_fs(config.memory_mhz)),
      core_in_memory_(ratio(core_fs_, memory_fs_)),
      memory_in_core_(ratio(memory_fs_, core_fs_)),
      link_(config.links.latency),
      latency_(config.links.latency + config.crossbar.latency),
      pipe_(config.l2.latency),
      interleave_(config.interleave),
      dram_(config.dram_config(bytes)),
      sector_bytes_(config.l2.geometry.sector_bytes),
      inputs_(config.sms),
      l2_(config.interleave.slices),
      ports_(config.sms) {
  const std::size_t capacity =
      config.l2.latency + config.l2.queue + config.crossbar.latency + config.crossbar.output_buffer;
  for (unsigned i = 0; i < config.interleave.slices; ++i) {
    Slice& slice = slices_.emplace_back(config.l2_slice(i), dram_.channel, capacity);
    const modules::DramTiming& t = dram_.channel.timing;
    slice.interval = t.ccd * kParts;
    slice.errors.fill(static_cast<std::int32_t>(t.rcd + t.cl + t.ccd));
  }
}

FastMemory::Ratio FastMemory::ratio(std::uint64_t a, std::uint64_t b) {
  const auto fraction = (static_cast<unsigned __int128>(a % b) << 64) / b;
  return {a / b, static_cast<std::uint64_t>(fraction)};
}

// Nearly in order: the SMs' turns are short.
void FastMemory::Slice::arrive(const Arrival& arrival) {
  arrivals.push_back(arrival);
  auto at = arrivals.end() - 1;
  for (; at != arrivals.begin() && arrival.clock < (at - 1)->clock; --at) *at = *(at - 1);
  *at = arrival;
}

FastMemory::Trip FastMemory::access(const MemoryRequest& request, Cycle sent) {
  const unsigned index = interleave_.slice(request.address);
  Slice& slice = slices_[index];
  // An SM's oldest request holds back those behind it; a slice takes one a cycle, as long as it has room.
  Cycle& input = inputs_[request.sm];
  const Cycle room = slice.looked_up[slice.next];
  const Cycle crossed = slice.input.reserve(std::max({sent + link_, input, room}));
  input = crossed + 1;
  const Cycle now = slice.lookup.reserve(std::max(crossed + latency_ - link_ + pipe_, slice.blocked_until));
  slice.looked_up[slice.next] = now;
  slice.next = slice.next + 1 == slice.looked_up.size() ? 0 : slice.next + 1;
  ++l2_[index].requests_in;
  ++l2_[index].replies_out;
  ++packets_;
  const Cycle replied = slice.reply.reserve(look_up(index, now, request));
  return {crossed - link_, ports_[request.sm].reserve(replied + latency_)};
}

// When the answer is there.
Cycle FastMemory::look_up(unsigned index, Cycle now, const MemoryRequest& request) {
  Slice& slice = slices_[index];
  modules::L2Counters::ByRegion& region = l2_[index].region[static_cast<std::size_t>(request.region)];
  ++(request.write ? region.writes : region.reads);
  if (slice.config.perfect) {
    ++(request.write ? region.write_hits : region.hits);
    return now;
  }
  const std::uint64_t local = interleave_.local(request.address);
  const std::uint8_t sector = slice.tags.sector_bit(local);
  SectorCacheTags::Slot slot = slice.tags.find(local);
  if (slot == SectorCacheTags::kNone) {
    SectorCacheTags::Victim victim;
    slot = slice.tags.insert(local, &victim);
    if (victim.valid) ++l2_[index].evictions;
    if (victim.dirty != 0) write_back(index, now, victim);
  } else {
    slice.tags.touch(slot);
  }
  const bool present = (slice.tags.valid(slot) & sector) != 0;
  slice.tags.set_valid(slot, sector);
  if (request.write) {
    region.write_hits += present ? 1 : 0;
    slice.tags.set_dirty(slot, sector);
    return now;
  }
  if (present) {
    ++region.hits;
    return now;
  }
  ++region.misses;
  ++l2_[index].dram_reads;
  const Cycle clock = after_core(now);
  const Cycle done = after_memory(clock + ask_dram(slice, clock, local, false));
  l2_[index].miss_latency.add(done - now);
  l2_[index].mshr_cycles += done - now;
  return done;
}

void FastMemory::write_back(unsigned index, Cycle now, const SectorCacheTags::Victim& victim) {
  Slice& slice = slices_[index];
  for (unsigned sector = 0; sector < slice.config.geometry.sectors(); ++sector) {
    if ((victim.dirty >> sector & 1) == 0) continue;
    ++l2_[index].dram_writes;
    ask_dram(slice, after_core(now), victim.address + std::uint64_t{sector} * sector_bytes_, true);
  }
}

// Memory clocks until a request that arrives at `clock` is answered; of a write, nobody asks.
Cycle FastMemory::ask_dram(Slice& slice, Cycle clock, std::uint64_t local, bool write) {
  if (dram_.perfect) {
    slice.dram.count_unqueued(sector_bytes_, write);
    ++responses_;
    return dram_.fixed_latency;
  }
  const std::size_t found = std::min<std::size_t>(waiting(slice), (1u << kFoundBits) - 1);
  slice.arrive({clock, local, write ? kWriteBack : clock << kFoundBits | found});
  if (write) return 0;
  const std::int64_t expected =
      static_cast<std::int64_t>(found) * slice.interval / kParts + slice.errors[slice.next_sample];
  slice.next_sample = slice.next_sample + 1 == kSamples ? 0 : slice.next_sample + 1;
  const modules::DramTiming& t = dram_.channel.timing;
  return static_cast<Cycle>(std::max<std::int64_t>(expected, t.cl + t.ccd)) + dram_.fixed_latency;
}

void FastMemory::advance(Cycle now) {
  if (now >= next_advance_) {
    for (PortCalendar& port : ports_) port.advance(now);
    for (Slice& slice : slices_) {
      for (PortCalendar* port : {&slice.input, &slice.lookup, &slice.reply}) port->advance(now);
    }
    next_advance_ = now + PortCalendar::kPeriod;
  }
  if (dram_.perfect) return;
  const Cycle known = now + latency_ + pipe_;  // what is sent later is looked up later
  for (Slice& slice : slices_) {
    run_dram(slice, after_core(known));
    const std::size_t room = slice.config.dram_queue + dram_.channel.queue;
    const std::size_t inside = waiting(slice);
    if (inside <= room) continue;
    const std::int64_t clocks = static_cast<std::int64_t>(inside - room) * slice.interval / kParts;
    slice.blocked_until = known + after_memory(static_cast<Cycle>(clocks));
    ++l2_[static_cast<std::size_t>(&slice - slices_.data())].stalls[static_cast<std::size_t>(L2Stall::dram_queue)];
  }
}

void FastMemory::drain() {
  for (Slice& slice : slices_) {
    while (!slice.arrivals.empty() || slice.outstanding != 0) {
      Cycle clock = slice.dram.next_command() == kNever ? 0 : slice.dram.next_command();
      if (!slice.arrivals.empty()) clock = std::max(clock, slice.arrivals.back().clock);
      run_dram(slice, clock + 1);
    }
    while (!slice.done.empty()) slice.done.pop();
  }
}

// The DRAM up to this memory clock: no request that arrives before it is missing.
void FastMemory::run_dram(Slice& slice, Cycle clock) {
  std::size_t taken = 0;
  for (; taken < slice.arrivals.size() && slice.arrivals[taken].clock < clock; ++taken) {
    const Arrival& request = slice.arrivals[taken];
    Cycle arrival = std::max(request.clock, slice.arrival_free);
    slice.dram.run_until(arrival - 1);
    if (!slice.dram.can_accept(sector_bytes_)) {
      const Cycle room = slice.dram.run_until_room(sector_bytes_) + 1;
      if (room > arrival) full_clocks_ += room - arrival;
      arrival = std::max(arrival, room);
    }
    slice.dram.enqueue(arrival, request.id, request.address, sector_bytes_, request.id == kWriteBack);
    slice.arrival_free = after_core(after_memory(arrival));
    ++slice.outstanding;
  }
  if (taken != 0) {
    slice.arrivals.erase(slice.arrivals.begin(), slice.arrivals.begin() + static_cast<std::ptrdiff_t>(taken));
  }
  slice.dram.run_until(clock);
  for (auto& done = slice.dram.completions(); !done.empty(); done.pop()) {
    const Cycle at = std::max(done.front().done, slice.response_free);
    slice.response_free = at + core_in_memory_.whole + 1;
    if (slice.outstanding > kBusy && at > slice.last_done) {
      slice.interval += (static_cast<std::int64_t>(at - slice.last_done) * kParts - slice.interval) / kWeight;
    }
    slice.last_done = at;
    const std::uint64_t id = done.front().id;
    if (id != kWriteBack) {
      const auto found = static_cast<std::int64_t>(id & ((1u << kFoundBits) - 1));
      const auto latency = static_cast<std::int64_t>(at - (id >> kFoundBits));
      slice.errors[slice.newest_sample] = static_cast<std::int32_t>(latency - found * slice.interval / kParts);
      slice.newest_sample = slice.newest_sample + 1 == kSamples ? 0 : slice.newest_sample + 1;
    }
    slice.done.push(at);
    --slice.outstanding;
    ++responses_;
  }
  while (!slice.done.empty() && slice.done.front() <= clock) slice.done.pop();
}

bool FastMemory::idle() const {
  return std::all_of(slices_.begin(), slices_.end(),
                     [](const Slice& s) { return s.arrivals.empty() && s.outstanding == 0 && s.done.empty(); });
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
