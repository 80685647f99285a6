#include "rtl_tlm/sampled/outline_memory.h"

#include <algorithm>

namespace grtx::tlm {

OutlineChannel::OutlineChannel(const modules::DramChannelConfig& config)
    : config_(config),
      banks_(config.banks),
      bus_(1, config.timing.ccd),
      activates_(1, config.timing.rrd),
      queue_(config.queue) {}

Cycle OutlineChannel::request(Cycle clock, std::uint64_t local, unsigned bursts, bool write) {
  const modules::DramTiming& t = config_.timing;
  const std::uint64_t number = local / config_.row_bytes;
  const std::uint64_t row = number / config_.banks;
  std::uint64_t index = number % config_.banks;
  if (config_.bank_xor) index ^= row % config_.banks;
  Bank& bank = banks_[index];
  clock = std::max(clock, queue_.room());
  Cycle column = 0;
  if (bank.newest.number == row) {
    column = std::max(clock, bank.newest.column);
  } else if (bank.before.number == row && clock + t.rp < bank.newest.activated) {
    column = std::max(clock, bank.before.column);
  } else {
    const Cycle closed =
        std::max(bank.last_column + (bank.wrote ? t.write_to_precharge() : t.rtp), bank.newest.activated + t.ras) +
        t.rp;
    const Cycle activate = activates_.reserve(std::max({clock, closed, bank.newest.activated + t.rc}));
    bank.before = bank.newest;
    bank.newest = {row, activate, activate + t.rcd};
    column = bank.newest.column;
    bank.wrote = false;
  }
  bank.wrote = bank.wrote || write;
  if (write && column > writes_until_) {
    // The bus turns around for the writes and back: reads lose these clocks.
    const unsigned lost = (t.read_to_write() + t.write_to_read() - 2 * t.ccd) / t.ccd;
    for (unsigned i = 0; i < lost; ++i) column = std::max(column, bus_.reserve(column));
    writes_until_ = column + 32;
  }
  for (unsigned i = 0; i < bursts; ++i) {
    column = bus_.reserve(column);
    queue_.take(column);
    bank.last_column = std::max(bank.last_column, column);
    if (i + 1 < bursts) column += t.ccd;
  }
  return column + (write ? t.wl : t.cl) + t.ccd;
}

OutlineMemory::OutlineMemory(const GpuConfig& config, const modules::Dram::Config& dram)
    : clocks_a_cycle_(config.memory_mhz / config.core_mhz),
      link_(config.links.latency),
      latency_(config.links.latency + config.crossbar.latency),
      pipe_(config.l2.latency),
      interleave_(config.interleave),
      dram_(dram),
      perfect_(config.l2.perfect),
      sector_bytes_(config.l2.geometry.sector_bytes),
      inputs_(config.sms) {
  const std::size_t capacity =
      config.l2.latency + config.l2.queue + config.crossbar.latency + config.crossbar.output_buffer;
  for (unsigned i = 0; i < config.interleave.slices; ++i) {
    slices_.emplace_back(config.l2_slice(i), dram_.channel, capacity);
  }
}

OutlineMemory::Trip OutlineMemory::access(unsigned sm, std::uint64_t line, std::uint8_t sectors, bool write,
                                          Cycle sent) {
  Slice& slice = slices_[interleave_.slice(line)];
  const auto count = static_cast<unsigned>(std::popcount(sectors));
  accesses += count;
  Cycle& input = inputs_[sm];
  Cycle now = 0;
  for (unsigned i = 0; i < count; ++i) {
    const Cycle crossed = slice.input.reserve(std::max({sent + link_, input, slice.looked_up.room()}));
    input = crossed + 1;
    now = crossed + latency_ - link_ + pipe_;  // in turn, as they crossed, unless the slice stood still
    if (slice.blocked_until > now) now = slice.lookup.reserve(slice.blocked_until);
    slice.looked_up.take(now);
  }
  Trip trip{input - 1 - link_, 0};
  const Cycle done = look_up(slice, line, sectors, write, now);
  for (unsigned i = count; i > 0; --i) {
    trip.seen = std::max(trip.seen, slice.reply.reserve(done - (i - 1)) + latency_);
  }
  return trip;
}

// When the last answer is there.
Cycle OutlineMemory::look_up(Slice& slice, std::uint64_t line, std::uint8_t sectors, bool write, Cycle now) {
  if (perfect_) return now;
  const std::uint64_t local = interleave_.local(line);
  modules::SectorCacheTags::Slot slot = slice.tags.find(local);
  if (slot == modules::SectorCacheTags::kNone) {
    modules::SectorCacheTags::Victim victim;
    slot = slice.tags.insert(local, &victim);
    if (victim.dirty != 0) {
      from_dram(slice, now, victim.address, static_cast<unsigned>(std::popcount(victim.dirty)), true);
    }
  } else {
    slice.tags.touch(slot);
  }
  const auto missing = static_cast<std::uint8_t>(sectors & ~slice.tags.valid(slot));
  slice.tags.set_valid(slot, sectors);
  if (write) {
    slice.tags.set_dirty(slot, sectors);
    return now;
  }
  if (missing == 0) return now;
  const auto first = static_cast<std::uint64_t>(std::countr_zero(missing)) * sector_bytes_;
  return from_dram(slice, now, local + first, static_cast<unsigned>(std::popcount(missing)), false);
}

Cycle OutlineMemory::from_dram(Slice& slice, Cycle now, std::uint64_t local, unsigned sectors, bool write) {
  dram_sectors += sectors;
  const Cycle clock = clock_of(now);
  if (dram_.perfect) return cycle_of(clock + dram_.fixed_latency);
  const unsigned bursts = sectors * ((sector_bytes_ + dram_.channel.burst_bytes - 1) / dram_.channel.burst_bytes);
  const Cycle enters = slice.dram.room();  // the channel's own queue
  const Cycle done = cycle_of(slice.dram.request(clock, local, bursts, write) + dram_.fixed_latency);
  for (unsigned i = 0; i < sectors; ++i) {
    if (!write) slice.mshrs.take(done);
    slice.queue.take(enters);
  }
  Cycle blocked = slice.queue.room() > clock ? cycle_of(slice.queue.room()) : 0;
  if (slice.mshrs.room() > now) blocked = std::max(blocked, slice.mshrs.room());
  slice.blocked_until = std::max(slice.blocked_until, blocked);
  return done;
}

void OutlineMemory::advance(Cycle now) {
  const Cycle clock = static_cast<Cycle>(static_cast<double>(now) * clocks_a_cycle_);
  for (Slice& slice : slices_) {
    slice.input.advance(now);
    slice.lookup.advance(now);
    slice.reply.advance(now);
    slice.dram.advance(clock);
  }
}

}  // namespace grtx::tlm
