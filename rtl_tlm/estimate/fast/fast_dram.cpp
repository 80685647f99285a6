#include "grtx/rtl_tlm/estimate/fast/fast_dram.h"

#include <algorithm>

namespace grtx::sim {

FastDramChannel::FastDramChannel(const modules::DramChannelConfig& config)
    : config_(config),
      banks_(config.banks),
      bus_(config.timing.ccd),
      activates_(1, config.timing.rrd),
      queue_(config.queue) {}

Cycle FastDramChannel::open(Cycle clock, Bank& bank, std::uint64_t row) {
  const modules::DramTiming& t = config_.timing;
  if (bank.newest.number == row) return std::max(clock, bank.newest.column);
  if (bank.before.number == row && clock + t.rp < bank.newest.activated) return std::max(clock, bank.before.column);
  ++counters_.activates;
  Cycle free = clock;
  if (bank.newest.number != kNoRow) {
    ++counters_.precharges;
    const Cycle written = bank.last_column + (bank.wrote ? t.write_to_precharge() : t.rtp);
    free = std::max({free, std::max(written, bank.newest.activated + t.ras) + t.rp, bank.newest.activated + t.rc});
  }
  const Cycle activate = activates_.reserve(free);
  bank.before = bank.newest;
  bank.newest = {row, activate, activate + t.rcd};
  bank.wrote = false;
  return bank.newest.column;
}

Cycle FastDramChannel::request(Cycle clock, std::uint64_t local, unsigned sectors, unsigned sector_bytes, bool write) {
  const modules::DramTiming& t = config_.timing;
  const std::uint64_t number = local / config_.row_bytes;
  const std::uint64_t row = number / config_.banks;
  std::uint64_t index = number % config_.banks;
  if (config_.bank_xor) index ^= row % config_.banks;
  Bank& bank = banks_[index];
  const std::uint64_t activates = counters_.activates;
  const std::uint64_t precharges = counters_.precharges;
  Cycle column = open(clock, bank, row);
  (write ? counters_.writes : counters_.reads) += sectors;
  counters_.bytes += std::uint64_t{sectors} * sector_bytes;
  if (counters_.activates == activates) {
    counters_.row_hits += sectors;
  } else {
    ++(counters_.precharges == precharges ? counters_.row_misses : counters_.row_conflicts);
    counters_.row_hits += sectors - 1;
  }
  bank.wrote = bank.wrote || write;
  if (write && column > writes_until_) {
    // The bus turns around for the writes and back: reads lose these clocks.
    const unsigned lost = (t.read_to_write() + t.write_to_read() - 2 * t.ccd) / t.ccd;
    for (unsigned i = 0; i < lost; ++i) column = std::max(column, bus_.reserve(column));
    writes_until_ = column + 32;
  }
  const unsigned bursts = sectors * ((sector_bytes + config_.burst_bytes - 1) / config_.burst_bytes);
  const unsigned data = (write ? t.wl : t.cl) + t.ccd;
  counters_.bursts += bursts;
  for (unsigned i = 0; i < bursts; ++i) {
    if (i != 0) column += t.ccd;
    column = bus_.reserve(column);
    queue_.take(column);
    bank.last_column = std::max(bank.last_column, column);
    counters_.queue_clocks += column - clock;
    if ((i + 1) * sectors % bursts == 0) counters_.latency_clocks += column + data - clock;
  }
  return column + data;
}

}  // namespace grtx::sim
