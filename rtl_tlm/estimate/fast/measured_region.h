// Where fast mode's error was measured, so that a run outside can say so.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

/// Fewer groups are too few: a run's end, which is a few warps, is then much of the run.
inline constexpr std::uint64_t kFewestMeasuredGroups = 128;

/// What of a machine and a trace of so many groups is outside, in words; empty: nothing. A number is inside within a
/// factor of four of its default, or of what the machines in configs/machines say.
std::string outside_of_measured(const GpuConfig& config, std::uint64_t groups);

}  // namespace grtx::sim
