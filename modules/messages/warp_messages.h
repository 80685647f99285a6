// SPDX-License-Identifier: Apache-2.0
// Messages between the SIMT core and the RT unit of an SM. One warp is one RayGroup of the trace in a warp slot.
#pragma once

#include <array>
#include <cstdint>

#include "grtx/base/strong.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

inline constexpr unsigned kMaxLanes = 32;

/// traceRay: the warp in slot `slot` of the SM passes round `round` of its `lanes` to the RT unit.
struct TraceCall {
  const traces::RayGroup* group = nullptr;  ///< valid until the matching TraceDone is consumed
  std::uint32_t round = 0;
  std::uint16_t slot = 0;
  LaneMask lanes = 0;  ///< lanes whose ray has a round with this number
};

/// Invokes the any-hit shader for `lanes` of the warp in `slot`; these lanes wait in the RT unit for AnyHitDone.
/// With procedural leaves (boxes) the intersection shader runs first, and the any-hit shader only for lanes with a hit.
struct AnyHitBatch {
  std::uint16_t slot = 0;
  std::uint32_t round = 0;
  LaneMask lanes = 0;
  std::array<traces::LeafOutcome, kMaxLanes> outcome{};  ///< [lane]
  std::array<std::uint16_t, kMaxLanes> shifts{};         ///< [lane] k-buffer entries that the insertion moved
  std::array<std::uint8_t, kMaxLanes> hidden{};          ///< [lane] k-buffer entries that leave (Event::hidden())
  /// [lane] leaf address, in units; with opacity_bound and two levels that of the instance leaf
  std::array<std::uint32_t, kMaxLanes> leaf{};
};

struct AnyHitDone {
  std::uint16_t slot = 0;
  LaneMask lanes = 0;
};

/// All lanes of the call have finished their traversal; the warp has left the RT unit.
struct TraceDone {
  std::uint16_t slot = 0;
  std::uint32_t round = 0;
};

/// The work distributor launches ray group `group` in the free warp slot `slot` of an SM.
struct LaunchWarp {
  const traces::RayGroup* group = nullptr;  ///< valid until the matching WarpEnded is consumed
  std::uint16_t slot = 0;
};

/// The warp has written its pixels and all its stores are acknowledged; its slot is free.
struct WarpEnded {
  std::uint16_t slot = 0;
};

}  // namespace grtx::modules
