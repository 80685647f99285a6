#include "grtx/rtl_tlm/estimate/fast/fast_dram.h"

#include <algorithm>

namespace grtx::sim {

FastDramChannel::FastDramChannel(const modules::DramChannelConfig& config)
    : config_(config),
      mapping_(config),
      banks_(config.banks),
      columns_(config.timing),
      activates_(config.timing),
      queue_(config.queue) {}

Cycle FastDramChannel::after_refresh(Cycle clock, Cycle closing) const {
  const Cycle due = refreshes(clock) * config_.timing.refi;
  return due == 0 ? clock : std::max(clock, due + closing + config_.timing.rfc);
}

// A place in a refresh is nobody's, so what is taken there on the way is not lost.
Cycle FastDramChannel::activate(Cycle clock, std::uint32_t bank) {
  const modules::DramTiming& t = config_.timing;
  for (;;) {
    clock = after_refresh(clock, t.ras + t.rp);  // rows opened just before it was due are closed first
    const Cycle taken = activates_.reserve(clock, mapping_.group(bank));
    clock = after_refresh(taken, t.ras + t.rp);
    if (clock == taken) return taken;
  }
}

Cycle FastDramChannel::open(Cycle clock, std::uint32_t number, std::uint64_t row, bool write) {
  const modules::DramTiming& t = config_.timing;
  Bank& bank = banks_[number];
  if (refreshes(clock) > refreshes(bank.newest.activated)) {  // which closed it
    if (bank.newest.number != kNoRow) ++counters_.precharges;
    bank = {};
    bank.newest.activated = refreshes(clock) * t.refi;
  }
  if (bank.newest.number == row) return std::max(clock, bank.newest.activated + to_column(write));
  if (bank.before.number == row && clock + t.rp < bank.newest.activated) {
    return std::max(clock, bank.before.activated + to_column(write));
  }
  ++counters_.activates;
  Cycle free = clock;
  if (bank.newest.number != kNoRow) {
    ++counters_.precharges;
    free = std::max({free, bank.can_precharge, bank.newest.activated + t.ras}) + t.rp;
    free = std::max(free, bank.newest.activated + t.rc);
  }
  bank.before = bank.newest;
  bank.newest = {row, activate(free, number)};
  return bank.newest.activated + to_column(write);
}

Cycle FastDramChannel::request(Cycle clock, std::uint64_t local, unsigned sectors, unsigned sector_bytes, bool write) {
  if (config_.bank_groups == 1) return request_row(clock, local, sectors, sector_bytes, write);
  Cycle done = 0;
  while (sectors > 0) {
    const std::uint64_t left = config_.group_bytes - local % config_.group_bytes;
    const unsigned here = std::min(sectors, std::max(1u, static_cast<unsigned>(left / sector_bytes)));
    done = std::max(done, request_row(clock, local, here, sector_bytes, write));
    local += std::uint64_t{here} * sector_bytes;
    sectors -= here;
  }
  return done;
}

Cycle FastDramChannel::request_row(Cycle clock, std::uint64_t local, unsigned sectors, unsigned sector_bytes,
                                   bool write) {
  const modules::DramTiming& t = config_.timing;
  const modules::DramMapping::Place place = mapping_.place(local);
  Bank& bank = banks_[place.bank];
  const std::uint64_t activates = counters_.activates;
  const std::uint64_t precharges = counters_.precharges;
  Cycle column = open(clock, place.bank, place.row, write);
  (write ? counters_.writes : counters_.reads) += sectors;
  counters_.bytes += std::uint64_t{sectors} * sector_bytes;
  if (counters_.activates == activates) {
    counters_.row_hits += sectors;
  } else {
    ++(counters_.precharges == precharges ? counters_.row_misses : counters_.row_conflicts);
    counters_.row_hits += sectors - 1;
  }
  const unsigned group = mapping_.group(place.bank);
  const unsigned bursts = sectors * ((sector_bytes + config_.burst_bytes - 1) / config_.burst_bytes);
  const unsigned data = (write ? t.wl : t.cl) + t.ccd;
  counters_.bursts += bursts;
  for (unsigned i = 0; i < bursts; ++i) {
    if (i != 0) column += t.ccd;
    column = write ? columns_.write(column, group) : columns_.read(column, group);
    if (refreshes(column) > refreshes(bank.newest.activated)) {  // in between the row was closed
      ++counters_.activates;
      bank.newest.activated = after_refresh(column, t.rp);
      column = bank.newest.activated + to_column(write);
      column = write ? columns_.write(column, group) : columns_.read(column, group);
    }
    counters_.refreshes = std::max(counters_.refreshes, refreshes(column));
    queue_.take(column);
    bank.can_precharge = std::max(bank.can_precharge, column + (write ? t.write_to_precharge() : t.rtp));
    counters_.queue_clocks += column - clock;
    if ((i + 1) * sectors % bursts == 0) counters_.latency_clocks += column + data - clock;
  }
  return column + data;
}

}  // namespace grtx::sim
