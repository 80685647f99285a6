// DRAM scheduling fr_fcfs_cap: fr_fcfs in which a bank serves only so many younger row hits before its oldest request
// (FR-FCFS+Cap of Mutlu and Moscibroda, MICRO 2007, with a cap of 4).
#pragma once

#include <bit>
#include <vector>

#include "grtx/modules/dram/decide/dram_config.h"
#include "grtx/modules/dram/decide/policies/fr_fcfs.h"

namespace grtx::modules {

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
  unsigned bits_per_bank() const override { return static_cast<unsigned>(std::bit_width(cap_)); }

 private:
  bool capped(const DramBankQueue& queue) const override { return overtaken_[queue.bank] >= cap_; }

  unsigned cap_;
  std::vector<unsigned> overtaken_;
};

}  // namespace grtx::modules
