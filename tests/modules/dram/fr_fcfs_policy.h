// fr_fcfs and fr_fcfs_cap said in the way of a policy, from what a policy is shown: the channel's own decisions must be
// these, and the interface must be able to say them.
#pragma once

#include <limits>
#include <vector>

#include "grtx/modules/dram/decide/dram_config.h"
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

/// Counts a bank's column commands that overtake its oldest request; what is counted is forgotten when that request
/// gets a command.
class FrFcfsCap final : public FrFcfs {
 public:
  explicit FrFcfsCap(const DramChannelConfig& channel)
      : FrFcfs(channel.age_cap), cap_(channel.hit_cap), overtaken_(channel.banks) {}

  DramChoice choose(Cycle now, const std::vector<DramBankQueue>& queues) override {
    const DramChoice choice = FrFcfs::choose(now, queues);
    if (choice.row != DramChoice::kNone) overtaken_[queues[choice.row].bank] = 0;
    if (choice.column != DramChoice::kNone) {
      const DramBankQueue& queue = queues[choice.column];
      unsigned& overtaken = overtaken_[queue.bank];
      overtaken = queue.hit == queue.oldest ? 0 : overtaken + 1;
    }
    return choice;
  }

 private:
  bool capped(const DramBankQueue& queue) const override { return overtaken_[queue.bank] >= cap_; }

  unsigned cap_;
  std::vector<unsigned> overtaken_;
};

}  // namespace grtx::modules
