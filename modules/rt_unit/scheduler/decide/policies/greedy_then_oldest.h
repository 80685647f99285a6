// SPDX-License-Identifier: Apache-2.0
// Warp selection policy greedy_then_oldest.
#pragma once

#include "grtx/modules/rt_unit/scheduler/decide/policies/oldest_first.h"

namespace grtx::modules {

/// Selects the last selected warp as long as it is a candidate, else the oldest.
class GreedyThenOldest final : public WarpSelection {
 public:
  unsigned select(LaneMask candidates, const std::vector<std::uint64_t>& ages, const SelectableWarps&) override {
    const bool stays = served_ && (candidates >> entry_ & 1) != 0 && ages[entry_] == age_;
    if (!stays) entry_ = OldestFirst::oldest(candidates, ages);
    age_ = ages[entry_];
    served_ = true;
    return entry_;
  }

 private:
  bool served_ = false;
  unsigned entry_ = 0;
  std::uint64_t age_ = 0;
};

}  // namespace grtx::modules
