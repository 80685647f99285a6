// SPDX-License-Identifier: Apache-2.0
// DRAM scheduling fr_fcfs_cap (FR-FCFS+Cap of Mutlu and Moscibroda, MICRO 2007): like fr_fcfs, but at most hit_cap
// column commands of a bank may overtake its oldest request.
#pragma once

#include <bit>
#include <vector>

#include "grtx/modules/dram/decide/dram_config.h"
#include "grtx/modules/dram/decide/policies/fr_fcfs.h"

namespace grtx::modules {

/// A bank's count is reset when its oldest request gets a command.
class FrFcfsCap final : public FrFcfs {
 public:
  explicit FrFcfsCap(const DramChannelConfig& channel)
      : FrFcfs(channel.age_cap), cap_(channel.hit_cap), overtaken_(channel.banks) {}

  DramChoice choose(Cycle now, const DramQueues& queues) override {
    const DramChoice choice = FrFcfs::choose(now, queues);
    if (choice.row != DramQueues::kNone) count(choice.row, false);
    if (choice.column != DramQueues::kNone) count(choice.column, (queues.overtaking >> choice.column & 1) != 0);
    return choice;
  }
  unsigned bits_per_bank() const override { return static_cast<unsigned>(std::bit_width(cap_)); }

 private:
  void count(unsigned bank, bool overtakes) {
    overtaken_[bank] = overtakes ? overtaken_[bank] + 1 : 0;
    const std::uint64_t bit = std::uint64_t{1} << bank;
    capped_ = overtaken_[bank] >= cap_ ? capped_ | bit : capped_ & ~bit;
  }

  unsigned cap_;
  std::vector<unsigned> overtaken_;
};

}  // namespace grtx::modules
