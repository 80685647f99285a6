// SPDX-License-Identifier: Apache-2.0
// Who fires: when the any-hit shader is called for a warp, and for which warp first. Paper, Section IV-B: "when all
// active rays in a warp hit a primitive or a timeout occurs".
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_table.h"

namespace grtx::modules {

class AnyHitFiring {
 public:
  /// timeout: cycles from a warp's first hit to its call, if other lanes still have none.
  explicit AnyHitFiring(std::uint64_t timeout) : timeout_(timeout) {}

  /// Cycle from which the warp may fire; 0: at once, as each of its active lanes has a hit.
  Cycle due(const Warp& warp) const {
    const bool all = warp.in_state(LaneState::waiting_any_hit) == warp.active();
    return all ? 0 : warp.any_hit_since + timeout_;
  }
  /// The oldest of the warps that are due, of `candidates` (entries of the warp buffer); nullopt if none is.
  std::optional<unsigned> next(const WarpTable& warps, WarpMask candidates, Cycle now) const {
    WarpMask eligible = 0;
    for_each_bit(candidates, [&](unsigned e) {
      if (due(warps.warp(e)) <= now) eligible |= bit(e);
    });
    if (eligible == 0) return std::nullopt;
    return warps.oldest(eligible);
  }
  /// Earliest cycle after `now` in which one of them is due if no lane changes its state; kNever if there is none.
  Cycle earliest(const WarpTable& warps, WarpMask candidates, Cycle now) const {
    Cycle next = kNever;
    for_each_bit(candidates, [&](unsigned e) { next = std::min(next, due(warps.warp(e))); });
    return next == kNever ? kNever : std::max(next, now + 1);
  }

 private:
  std::uint64_t timeout_;
};

}  // namespace grtx::modules
