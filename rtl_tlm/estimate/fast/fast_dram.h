// A DRAM channel in fast mode: bank rows, activates and the data bus as resources that a request reserves when it is
// made. It makes no commands in the order of time, as the cycle model's FR-FCFS scheduler does: a request that finds
// its row open, or about to be, joins it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "grtx/modules/dram/decide/dram_channel.h"
#include "grtx/rtl_tlm/estimate/fast/activate_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/column_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/place_calendar.h"

namespace grtx::sim {

/// All times in memory clocks.
class FastDramChannel {
 public:
  explicit FastDramChannel(const modules::DramChannelConfig& config);

  /// `sectors` sectors of one line, from `local` (address inside the channel) on, that arrive at `clock`. Returns when
  /// the last data is there.
  Cycle request(Cycle clock, std::uint64_t local, unsigned sectors, unsigned sector_bytes, bool write);
  /// Counts what a perfect memory answers.
  void count_unqueued(unsigned sectors, unsigned sector_bytes, bool write) {
    (write ? counters_.writes : counters_.reads) += sectors;
    counters_.bytes += std::uint64_t{sectors} * sector_bytes;
  }
  /// The first clock from `from` on in which the queue has room for one more burst.
  Cycle room(Cycle from) { return queue_.room(from); }
  /// Nothing arrives before `clock` any more.
  void advance(Cycle clock) {
    columns_.advance(clock);
    activates_.advance(clock);
  }
  /// Before the first request: rows are open as those of `before` are.
  void keep_rows(const FastDramChannel& before) {
    for (std::size_t i = 0; i < banks_.size(); ++i) banks_[i].newest.number = before.banks_[i].newest.number;
  }
  /// What keep_rows() takes over.
  void save(StateWriter& state) const {
    for (const Bank& bank : banks_) state.put(bank.newest.number);
  }
  void load(StateReader& state) {
    for (Bank& bank : banks_) bank.newest.number = state.get<std::uint64_t>();
  }
  /// Precharges are those that a row conflict needs; requests do not age.
  const modules::DramChannelCounters& counters() const { return counters_; }
  /// Bursts whose command came by that clock, at least: the bus serves those behind it one after the other.
  std::uint64_t bursts_by(Cycle clock) const {
    if (columns_.end() <= clock) return counters_.bursts;
    const std::uint64_t later = (columns_.end() - clock - 1) / config_.timing.ccd + 1;
    return counters_.bursts - std::min(counters_.bursts, later);
  }

 private:
  static constexpr std::uint64_t kNoRow = ~std::uint64_t{0};

  struct Row {
    std::uint64_t number = kNoRow;
    Cycle activated = 0;
  };
  struct Bank {
    Row newest;
    Row before;  ///< still open for requests that come before the newest is activated
    Cycle can_precharge = 0;
  };

  /// The same for sectors of one row.
  Cycle request_row(Cycle clock, std::uint64_t local, unsigned sectors, unsigned sector_bytes, bool write);
  /// The earliest column command for the row; opens it if need be.
  Cycle open(Cycle clock, std::uint32_t number, std::uint64_t row, bool write);
  /// Takes a place among activates, no earlier than `clock`.
  Cycle activate(Cycle clock, std::uint32_t bank);
  unsigned to_column(bool write) const { return write ? config_.timing.activate_to_write() : config_.timing.rcd; }
  /// Refreshes that are due by a clock.
  Cycle refreshes(Cycle clock) const { return config_.timing.refi == 0 ? 0 : clock / config_.timing.refi; }
  /// The clock, or the end of the refresh that is under way, which began `closing` clocks after it was due.
  Cycle after_refresh(Cycle clock, Cycle closing) const;

  modules::DramChannelConfig config_;
  modules::DramMapping mapping_;
  std::vector<Bank> banks_;
  ColumnCalendar columns_;
  ActivateCalendar activates_;
  PlaceCalendar queue_;
  modules::DramChannelCounters counters_;
};

}  // namespace grtx::sim
