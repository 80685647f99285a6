// SPDX-License-Identifier: Apache-2.0
// DRAM scheduling fr_fcfs: first ready, first come (Rixner et al., ISCA 2000), with an age cap.
#pragma once

#include <algorithm>

#include "grtx/modules/dram/decide/dram_scheduling.h"

namespace grtx::modules {

/// The oldest row hit that timing allows gets the column command; the oldest request whose row is not open gets the row
/// command. Nothing overtakes a request past the age cap: its bank serves no younger hits, and the data bus waits for
/// it once its row is open.
class FrFcfs : public DramScheduling {
 public:
  explicit FrFcfs(Cycle age_cap) : age_cap_(age_cap) {}

  DramChoice choose(Cycle now, const DramQueues& queues) override {
    DramChoice choice;
    const std::uint64_t first = hits_first(now, queues, choice.again);
    choice.column = DramQueues::oldest_of(queues.columns & first, queues.hit);
    choice.row = DramQueues::oldest_of(queues.rows & ~first, queues.oldest);
    if (now >= none_aged_before_ && choice.column != DramQueues::kNone) {
      const unsigned oldest = DramQueues::oldest_of(first, queues.hit);
      if (oldest != choice.column && now >= ages_at(queues.hit[oldest])) choice.column = DramQueues::kNone;
    }
    choice.declined_rows = queues.overtaking & first;
    choice.declined_columns = queues.hits & ~first;
    return choice;
  }

 protected:
  std::uint64_t capped_ = 0;  ///< banks whose oldest request must not be overtaken any more

 private:
  Cycle ages_at(const QueuedRequest& request) const { return request.since + age_cap_ + 1; }

  /// Banks that serve their hit before their oldest request. again: set to the first clock in which this may change.
  std::uint64_t hits_first(Cycle now, const DramQueues& queues, Cycle& again) {
    std::uint64_t first = queues.hits & ~(queues.overtaking & capped_);
    if (now < none_aged_before_) {
      again = none_aged_before_;
      return first;
    }
    none_aged_before_ = now + age_cap_ + 1;  // for requests that arrive from now on
    for (std::uint64_t rest = queues.busy; rest != 0; rest &= rest - 1) {
      const auto bank = static_cast<unsigned>(std::countr_zero(rest));
      const Cycle ages = ages_at(queues.oldest[bank]);
      none_aged_before_ = std::min(none_aged_before_, ages);
      if ((queues.overtaking >> bank & 1) == 0) continue;
      if (now >= ages) {
        first &= ~(std::uint64_t{1} << bank);
      } else {
        again = std::min(again, ages);
      }
    }
    return first;
  }

  Cycle age_cap_;
  Cycle none_aged_before_ = 0;  ///< no request is past the age cap before this clock
};

}  // namespace grtx::modules
