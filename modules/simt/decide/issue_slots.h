// The warp schedulers of an SM as resources that shader phases reserve: one warp instruction a cycle and scheduler.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/base/strong.h"
#include "grtx/modules/kernel/other_work.h"

namespace grtx::modules {

/// Warp slot s belongs to scheduler s mod schedulers. A phase is served as a whole, first come first served: the caller
/// reserves in the order in which phases became ready.
class IssueSlots {
 public:
  /// other_share: of each scheduler's cycles, that other work takes; sm: whose schedulers they are.
  IssueSlots(unsigned schedulers, unsigned instruction_latency, double other_share = 0.0, unsigned sm = 0)
      : free_(schedulers, 0), latency_(instruction_latency) {
    if (other_share == 0.0) return;
    for (unsigned i = 0; i < schedulers; ++i) {
      others_.emplace_back(other_share, SharedResource::issue, std::uint64_t{sm} * kMostSchedulers + i);
    }
  }

  /// Reserves `instructions` issue cycles for the warp in `slot`, beginning at max(now + 1, scheduler free): all from
  /// there on, or those that other work leaves. Returns the cycle in which the result of the last one is there: the one
  /// behind it + latency.
  Cycle reserve(unsigned slot, std::uint64_t instructions, Cycle now) {
    const std::size_t scheduler = slot % free_.size();
    Cycle& free = free_[scheduler];
    free = free > now + 1 ? free : now + 1;
    if (others_.empty() || instructions == 0) {
      free += instructions;
    } else {
      free = others_[scheduler].last_of(free, instructions) + 1;
    }
    busy_cycles_ += instructions;
    wait_cycles_ += free - instructions - (now + 1);
    return free + latency_;
  }

  std::uint64_t busy_cycles() const { return busy_cycles_; }  ///< issue cycles used, all schedulers
  /// Cycles phases waited for their scheduler, before their first instruction and between two.
  std::uint64_t wait_cycles() const { return wait_cycles_; }
  /// First cycle from which the scheduler of `slot` is free.
  Cycle free_from(unsigned slot) const { return free_[slot % free_.size()]; }

 private:
  static constexpr std::uint64_t kMostSchedulers = 64;

  std::vector<Cycle> free_;
  std::vector<OtherWork> others_;  ///< by scheduler; empty: none
  Cycle latency_;
  std::uint64_t busy_cycles_ = 0;
  std::uint64_t wait_cycles_ = 0;
};

}  // namespace grtx::modules
