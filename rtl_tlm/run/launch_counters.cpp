// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/launch_counters.h"

namespace grtx::sim {

void LaunchCounters::launched(unsigned sm, unsigned slot, const traces::RayGroup& group, Cycle now) {
  if (counters_.size() < positions_.size() && positions_[counters_.size()] == launched_) {
    SettledCounters so_far;
    for (const auto& one : gpu_.sms()) {
      for (const auto& rt : one->rt_units()) so_far.rt_of.push_back(rt->counters());
    }
    so_far.memory_busy_cycles = memory_.busy_core_cycles();
    counters_.push_back(collect_counters(gpu_, memory_, so_far));
    counters_.back().cycles = now;
  }
  ++launched_;
  if (observer_ != nullptr) observer_->launched(sm, slot, group, now);
}

}  // namespace grtx::sim
