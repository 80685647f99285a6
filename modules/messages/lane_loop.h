// SPDX-License-Identifier: Apache-2.0
// Lane numbers of the warp buffer, and a loop over the set bits of a lane mask.
#pragma once

#include <bit>
#include <cstdint>

#include "grtx/base/strong.h"
#include "grtx/modules/messages/warp_messages.h"

namespace grtx::modules {

/// A lane of the warp buffer: entry * kMaxLanes + lane. Also the tag of its memory requests.
using LaneId = std::uint16_t;

constexpr LaneId lane_id(unsigned entry, unsigned lane) { return static_cast<LaneId>(entry * kMaxLanes + lane); }
constexpr unsigned entry_of(LaneId id) { return id / kMaxLanes; }
constexpr unsigned lane_of(LaneId id) { return id % kMaxLanes; }
constexpr LaneMask bit(unsigned index) { return LaneMask{1} << index; }

/// Calls f(index) for every set bit, lowest first.
template <typename F>
constexpr void for_each_bit(LaneMask mask, F&& f) {
  while (mask != 0) {
    f(static_cast<unsigned>(std::countr_zero(mask)));
    mask &= mask - 1;
  }
}

/// Prefetches a cache line of the host; `address` need not be valid. A lane's next read is known well in advance.
inline void prefetch_for_read(const void* address) { __builtin_prefetch(address, 0, 3); }

}  // namespace grtx::modules
