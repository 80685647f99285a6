// SPDX-License-Identifier: Apache-2.0
// The warp schedulers of an SM as resources that shader phases reserve: one warp instruction per cycle and scheduler.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/base/strong.h"

namespace grtx::modules {

/// Warp slot s belongs to scheduler s mod schedulers. A phase is issued as a whole, first come first served: the caller
/// must reserve in the order in which phases become ready.
class IssueSlots {
 public:
  IssueSlots(unsigned schedulers, unsigned instruction_latency) : free_(schedulers, 0), latency_(instruction_latency) {}

  /// Reserves `instructions` issue cycles for the warp in `slot`, beginning at max(now + 1, scheduler free). Returns
  /// the cycle in which the last result is available: begin + instructions + latency.
  Cycle reserve(unsigned slot, std::uint64_t instructions, Cycle now) {
    Cycle& free = free_[slot % free_.size()];
    free = free > now + 1 ? free : now + 1;
    wait_cycles_ += free - (now + 1);
    free += instructions;
    busy_cycles_ += instructions;
    return free + latency_;
  }

  std::uint64_t busy_cycles() const { return busy_cycles_; }  ///< issue cycles used, all schedulers
  std::uint64_t wait_cycles() const { return wait_cycles_; }  ///< cycles that phases waited for their scheduler
  /// First cycle in which the scheduler of `slot` is free.
  Cycle free_from(unsigned slot) const { return free_[slot % free_.size()]; }

 private:
  std::vector<Cycle> free_;
  Cycle latency_;
  std::uint64_t busy_cycles_ = 0;
  std::uint64_t wait_cycles_ = 0;
};

}  // namespace grtx::modules
