// The enumerated signals of a waveform: names of the values, and the colours that viewers show them in.
#pragma once

#include "grtx/modules/rt_unit/warp_buffer.h"
#include "grtx/rtl_tlm/observe/vcd_writer.h"

namespace grtx::sim {

/// What a warp of the warp buffer waits for: the most advanced thing that any of its lanes can do.
enum class WarpState : std::uint8_t { free, ready, memory, unit, checkpoint, stack, any_hit, finished };
WarpState state_of(const modules::Warp& warp);

const Enumeration& warp_states();
/// What the RT scheduler did: none (a warp was scheduled), or the reason why not (StallFollower::look()).
const Enumeration& stall_reasons();
/// What an intersection unit, a cache or a memory does.
enum class UnitState : std::uint8_t { idle, busy, waiting };
const Enumeration& unit_states();
/// Node that a warp fetches or tests.
enum class NodeSignal : std::uint8_t { none, internal, instance, triangle, procedural };
const Enumeration& node_kinds();
/// What a warp slot of the SIMT core does: free, or 1 + WarpActivity.
const Enumeration& activities();

}  // namespace grtx::sim
