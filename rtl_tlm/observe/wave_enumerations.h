// SPDX-License-Identifier: Apache-2.0
// The enumerated signals of a waveform: names of the values, and the colours that viewers show them in.
#pragma once

#include <cstdint>

#include "grtx/rtl_tlm/observe/vcd_writer.h"

namespace grtx::sim {

/// State of a warp-buffer entry: free, or 1 + WarpWait.
const Enumeration& warp_states();
/// Action of the RT scheduler: none (a warp was scheduled), or the reason for a stall (StallFollower::look()).
const Enumeration& stall_reasons();
/// State of a unit (modules::UnitState).
const Enumeration& unit_states();
/// Kind of the node that a warp fetches or tests.
enum class NodeSignal : std::uint8_t { none, internal, instance, triangle, procedural };
const Enumeration& node_kinds();
/// State of a warp slot of the SIMT core: free, or 1 + WarpActivity.
const Enumeration& activities();

}  // namespace grtx::sim
