// SPDX-License-Identifier: Apache-2.0
// Derives from an RT scheduler's counters what it did in each cycle: schedule a warp, or stall for a reason. Cycles in
// which its unit sleeps are counted only later, with the reason of the state it sleeps in.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "grtx/modules/rt_unit/scheduler/scheduler_base.h"

namespace grtx::sim {

class StallFollower {
 public:
  /// Names of the values that look() returns: 0 a warp was scheduled, else 1 + the Stall.
  static std::vector<std::string> names() {
    std::vector<std::string> names = {"none"};
    for (const std::string& name : names_of<modules::Stall>()) names.emplace_back(name);
    return names;
  }

  /// Call after every cycle. accounted: the RT unit's first cycle not counted yet. The first call of a run that is
  /// under way gives the reason of the present state, all others are exact.
  unsigned look(Cycle now, Cycle accounted, const modules::RtSchedulerState& scheduler) {
    const auto& stall = scheduler.counters().stall;
    if (now < last_) started_ = false;  // another launch
    last_ = now;
    if (now == 0) seen_ = {};
    if (accounted <= now) {  // asleep in this cycle
      const auto reason = static_cast<std::size_t>(scheduler.stall_reason());
      if (!started_) {
        seen_ = stall;
        seen_[reason] += now + 1 - accounted;
        started_ = true;
      } else {
        ++seen_[reason];
      }
      return static_cast<unsigned>(reason) + 1;
    }
    unsigned found = 0;
    if (started_ || now == 0) {
      for (std::size_t r = 0; r < modules::kStalls; ++r) {
        if (stall[r] != seen_[r]) found = static_cast<unsigned>(r) + 1;
      }
    } else {
      found = static_cast<unsigned>(scheduler.stall_reason()) + 1;
    }
    started_ = true;
    seen_ = stall;
    return found;
  }

 private:
  std::array<std::uint64_t, modules::kStalls> seen_{};
  Cycle last_ = 0;
  bool started_ = false;
};

}  // namespace grtx::sim
