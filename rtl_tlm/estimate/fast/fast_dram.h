// A DRAM channel in fast mode: bank rows, activates and the data bus as resources that a request reserves when it is
// made. It makes no commands in the order of time, as the cycle model's FR-FCFS scheduler does: a request that finds
// its row open, or about to be, joins it.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/modules/dram/dram_channel.h"
#include "grtx/rtl_tlm/estimate/fast/place_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/slot_calendar.h"
#include "grtx/rtl_tlm/estimate/fast/span_calendar.h"

namespace grtx::sim {

/// All times in memory clocks.
class FastDramChannel {
 public:
  explicit FastDramChannel(const modules::DramChannelConfig& config);

  /// `sectors` sectors of one row, from `local` (address inside the channel) on, that arrive at `clock`. Returns when
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
    bus_.advance(clock);
    activates_.advance(clock);
  }
  /// Precharges are those that a row conflict needs; requests do not age.
  const modules::DramChannelCounters& counters() const { return counters_; }

 private:
  static constexpr std::uint64_t kNoRow = ~std::uint64_t{0};

  struct Row {
    std::uint64_t number = kNoRow;
    Cycle activated = 0;
    Cycle column = 0;  ///< earliest column command
  };
  struct Bank {
    Row newest;
    Row before;  ///< still open for requests that come before the newest is activated
    Cycle last_column = 0;
    bool wrote = false;
  };

  /// The earliest column command for the row; opens it if need be.
  Cycle open(Cycle clock, Bank& bank, std::uint64_t row);

  modules::DramChannelConfig config_;
  std::vector<Bank> banks_;
  SpanCalendar bus_;
  SlotCalendar activates_;
  Cycle writes_until_ = 0;  ///< until when writes find the bus turned around for them
  PlaceCalendar queue_;
  modules::DramChannelCounters counters_;
};

}  // namespace grtx::sim
