// SPDX-License-Identifier: Apache-2.0
// The reason for which a warp in the warp buffer waits, and the reason for which no warp is scheduled in a cycle.
#pragma once

#include <cstddef>
#include <cstdint>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/warp_messages.h"

namespace grtx::modules {

/// Reason for which a warp waits: the first of these that applies to one of its lanes (wait_of()).
enum class WarpWait : std::uint8_t {
  ready,       ///< a lane is ready: to be selected by the scheduler
  memory,      ///< a lane waits for a node
  checkpoint,  ///< a lane waits to read or hand over checkpoint entries
  stack,       ///< a lane waits for stack entries to be spilled or filled
  unit,        ///< a lane is queued at or inside an intersection unit
  any_hit,     ///< all unfinished lanes wait for the any-hit shader
  retire,      ///< all lanes have finished
};
constexpr auto enum_names(WarpWait) {
  return names_in_order<WarpWait>({"ready", "memory", "checkpoint", "stack", "unit", "any_hit", "retire"});
}
inline constexpr std::size_t kWarpWaits = kCountOf<WarpWait>;

/// Reason for which a warp waits, from the masks of its lanes in each state.
constexpr WarpWait wait_of(LaneMask ready, LaneMask memory, LaneMask checkpoint, LaneMask stack, LaneMask unit,
                           LaneMask any_hit) {
  if (ready != 0) return WarpWait::ready;
  if (memory != 0) return WarpWait::memory;
  if (checkpoint != 0) return WarpWait::checkpoint;
  if (stack != 0) return WarpWait::stack;
  if (unit != 0) return WarpWait::unit;
  return any_hit != 0 ? WarpWait::any_hit : WarpWait::retire;
}

/// Why no warp was scheduled in a cycle: the first reason that applies, in this order, to the oldest warp.
enum class Stall : std::uint8_t {
  empty,       ///< no warp in the buffer
  queue_full,  ///< a lane is ready, but the memory scheduler's queue lacks room
  memory,      ///< a lane waits for a node
  checkpoint,  ///< a lane waits to read or hand over checkpoint entries
  stack,       ///< a lane waits for stack entries to be spilled or filled
  unit,        ///< a lane is queued at or inside an intersection unit
  any_hit,     ///< all unfinished lanes wait for the any-hit shader
  retire,      ///< all lanes have finished; the SIMT core's queue of finished calls is full, or another warp retires
};
constexpr auto enum_names(Stall) {
  return names_in_order<Stall>({"empty", "queue_full", "memory", "checkpoint", "stack", "unit", "any_hit", "retire"});
}
inline constexpr std::size_t kStalls = kCountOf<Stall>;

/// The stall reason if no warp is ready. oldest: the reason for which the oldest warp waits.
constexpr Stall stall_of(WarpWait oldest) {
  switch (oldest) {
    case WarpWait::memory:
      return Stall::memory;
    case WarpWait::checkpoint:
      return Stall::checkpoint;
    case WarpWait::stack:
      return Stall::stack;
    case WarpWait::unit:
      return Stall::unit;
    case WarpWait::any_hit:
      return Stall::any_hit;
    default:
      return Stall::retire;
  }
}

}  // namespace grtx::modules
