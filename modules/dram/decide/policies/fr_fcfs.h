// DRAM scheduling fr_fcfs: first ready, first come (Rixner et al., ISCA 2000), with an age cap.
#pragma once

#include <limits>
#include <vector>

#include "grtx/modules/dram/decide/dram_scheduling.h"

namespace grtx::modules {

/// The oldest row hit whose timing allows it gets the column command; the oldest request whose bank holds another row,
/// or none, gets the row command. A request older than the cap lets nothing overtake it: its bank serves no younger
/// hits, and the data bus waits for it once its row is open.
class FrFcfs : public DramScheduling {
 public:
  explicit FrFcfs(Cycle age_cap) : age_cap_(age_cap) {}

  DramChoice choose(Cycle now, const std::vector<DramBankQueue>& queues) override {
    DramChoice choice;
    std::size_t oldest_hit = DramChoice::kNone;  // ready or not
    const auto take_older = [&queues](std::size_t& taken, std::size_t i, std::uint64_t DramBankQueue::*request) {
      if (taken == DramChoice::kNone || queues[i].*request < queues[taken].*request) taken = i;
    };
    for (std::size_t i = 0; i < queues.size(); ++i) {
      const DramBankQueue& queue = queues[i];
      const bool hit_first = queue.hit == queue.oldest || (!aged(now, queue.oldest_since) && !capped(queue));
      if (queue.has_hit && hit_first) {
        take_older(oldest_hit, i, &DramBankQueue::hit);
        if (queue.column_ready) take_older(choice.column, i, &DramBankQueue::hit);
      } else if (queue.row_ready) {
        take_older(choice.row, i, &DramBankQueue::oldest);
      }
    }
    if (choice.column != oldest_hit && aged(now, queues[oldest_hit].hit_since)) choice.column = DramChoice::kNone;
    return choice;
  }

 protected:
  /// Whether the bank's oldest request, which wants another row, has waited for enough younger ones.
  virtual bool capped(const DramBankQueue&) const { return false; }

 private:
  bool aged(Cycle now, Cycle since) const { return now - since > age_cap_; }

  Cycle age_cap_;
};

}  // namespace grtx::modules
