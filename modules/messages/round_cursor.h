// SPDX-License-Identifier: Apache-2.0
// Finds the events of one round for each ray of a group. Rounds usually come in order, so the event offsets are
// advanced from the previous round; any other round is found by summing from the start.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "grtx/base/error.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

class RoundCursor {
 public:
  /// Moves to `round` of `group` for all of its rays. Throws Error if the group has more than 32 rays.
  void seek(const traces::RayGroup& group, std::uint32_t round) {
    if (group.rays.size() > kMaxLanes) throw Error("trace", "group " + std::to_string(group.index), "at most 32 rays");
    const bool next = group_ == &group && index_ == group.index && round > 0 && round == round_ + 1;
    std::uint32_t from = round_;
    if (!next) {
      offset_.fill(0);
      from = 0;
    }
    for (std::size_t lane = 0; lane < group.rays.size(); ++lane) {
      const traces::Ray& ray = group.rays[lane];
      for (std::uint32_t r = from; r < round && r < ray.rounds.size(); ++r) offset_[lane] += ray.rounds[r].event_count;
    }
    group_ = &group;
    index_ = group.index;
    round_ = round;
  }
  /// Events of the current round of `lane`. Throws Error if its ray does not have the round.
  std::span<const traces::Event> events(unsigned lane) const {
    const auto inside = [&](const traces::Ray& ray) {
      return round_ < ray.rounds.size() && offset_[lane] + ray.rounds[round_].event_count <= ray.events.size();
    };
    if (lane >= group_->rays.size() || !inside(group_->rays[lane])) {
      throw Error("trace",
                  "group " + std::to_string(group_->index) + " lane " + std::to_string(lane) + " round " +
                      std::to_string(round_),
                  "a called round must exist and its events lie inside the ray");
    }
    const traces::Ray& ray = group_->rays[lane];
    return {ray.events.data() + offset_[lane], ray.rounds[round_].event_count};
  }
  const traces::Round& round(unsigned lane) const { return group_->rays[lane].rounds[round_]; }

 private:
  const traces::RayGroup* group_ = nullptr;
  std::uint32_t index_ = 0;
  std::uint32_t round_ = 0;
  std::array<std::uint64_t, kMaxLanes> offset_{};
};

}  // namespace grtx::modules
