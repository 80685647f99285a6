// SPDX-License-Identifier: Apache-2.0
// Plain work distributor: docs/model/work_distributor.md, docs/model/secondary-rays.md.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "grtx/traces/event.h"
#include "rtl_tlm/plain/messages.h"
#include "rtl_tlm/plain/statistics.h"

namespace grtx::sim::plain {

class WorkDistributor {
 public:
  struct Port {
    Channel<Launch>* launch;
    Channel<WarpEnded>* ended;
  };
  WorkDistributor(const std::vector<traces::RayGroup>& groups, std::vector<Port> sms, unsigned slots)
      : groups_(groups), sms_(std::move(sms)), used_(sms_.size(), std::vector<bool>(slots)), warps_(sms_.size()) {
    last_ = sms_.size() - 1;
  }

  void tick(Cycle now) {
    if (done_) return;
    for (std::size_t s = 0; s < sms_.size(); ++s) {
      while (sms_[s].ended->front(now) != nullptr) {
        used_[s][sms_[s].ended->pop(now).slot] = false;
        --running_;
      }
    }
    const bool left = next_ < groups_.size();
    if (running_ == 0 && started_ && (!left || launch_of(next_) != current_)) {
      (current_.second ? secondary_cycles_ : primary_cycles_) += now - launch_start_;
      launch_start_ = now;
      started_ = false;
    }
    if (left && !started_) {
      current_ = launch_of(next_);
      started_ = true;
    }
    if (left && launch_of(next_) == current_) launch(now);
    if (!left && running_ == 0) {
      done_ = true;
      end_ = now;
    }
  }

  bool done() const { return done_; }
  Cycle end_cycle() const { return end_; }
  std::uint64_t warps(std::size_t sm) const { return warps_[sm]; }
  void report(Statistics& s) const {
    s.add("gpu.distributor.groups", next_);
    s.add("gpu.distributor.most_on_one_sm", *std::max_element(warps_.begin(), warps_.end()));
    s.add("gpu.distributor.fewest_on_one_sm", *std::min_element(warps_.begin(), warps_.end()));
    s.add("gpu.distributor.tail_cycles", end_ - last_launch_);
    s.add("gpu.rays.primary_cycles", primary_cycles_);
    s.add("gpu.rays.secondary_cycles", secondary_cycles_);
  }

 private:
  /// Frame, and whether its secondary rays.
  using LaunchId = std::pair<std::uint32_t, bool>;
  LaunchId launch_of(std::size_t group) const {
    return {groups_[group].frame, groups_[group].kind != traces::RayKind::primary};
  }
  void launch(Cycle now) {
    for (std::size_t i = 1; i <= sms_.size(); ++i) {
      const std::size_t sm = (last_ + i) % sms_.size();
      const auto slot = std::find(used_[sm].begin(), used_[sm].end(), false);
      if (slot == used_[sm].end() || !sms_[sm].launch->has_room(now)) continue;
      *slot = true;
      sms_[sm].launch->push(now, {&groups_[next_++], static_cast<unsigned>(slot - used_[sm].begin())});
      ++running_;
      ++warps_[sm];
      last_ = sm;
      last_launch_ = now;
      return;
    }
  }

  const std::vector<traces::RayGroup>& groups_;
  std::vector<Port> sms_;
  std::vector<std::vector<bool>> used_;  ///< [sm][slot]
  std::vector<std::uint64_t> warps_;     ///< [sm]
  std::size_t next_ = 0, running_ = 0, last_ = 0;
  bool started_ = false, done_ = false;
  LaunchId current_;
  Cycle end_ = 0, launch_start_ = 0, primary_cycles_ = 0, secondary_cycles_ = 0, last_launch_ = 0;
};

}  // namespace grtx::sim::plain
