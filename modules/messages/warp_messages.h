// What the SIMT core and the RT unit of an SM tell each other. One warp = one RayGroup of the trace in a resident slot.
#pragma once

#include <array>
#include <cstdint>

#include "grtx/base/strong.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

inline constexpr unsigned kMaxLanes = 32;

/// traceRay: the warp in SM-resident slot `slot` hands round `round` of its `lanes` to the RT unit.
struct TraceCall {
  const traces::RayGroup* group = nullptr;  ///< stays valid until the matching TraceDone was consumed
  std::uint32_t round = 0;
  std::uint16_t slot = 0;
  LaneMask lanes = 0;  ///< lanes whose ray has a round with this number
};

/// The any-hit shader is invoked for `lanes` of the warp in `slot`; those lanes wait in the RT unit for AnyHitDone.
/// For a structure of boxes the intersection shader is called, and the any-hit shader only for those lanes that it
/// gives a hit.
struct AnyHitBatch {
  std::uint16_t slot = 0;
  std::uint32_t round = 0;
  LaneMask lanes = 0;
  std::array<traces::LeafOutcome, kMaxLanes> outcome{};  ///< of each lane in `lanes`
  std::array<std::uint16_t, kMaxLanes> shifts{};         ///< k-buffer entries its insertion moved
  std::array<std::uint32_t, kMaxLanes> leaf{};           ///< address of its leaf, units
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

/// The work distributor gives ray group `group` to the free warp slot `slot` of an SM.
struct LaunchWarp {
  const traces::RayGroup* group = nullptr;  ///< stays valid until the matching WarpEnded was consumed
  std::uint16_t slot = 0;
};

/// The warp has written its pixels and all its stores are acknowledged; its slot is free.
struct WarpEnded {
  std::uint16_t slot = 0;
};

}  // namespace grtx::modules
