// Where fast mode's error was measured, so that a run outside can say so.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "grtx/rtl_tlm/gpu/gpu_config.h"
#include "grtx/rtl_tlm/run/result_notes.h"

namespace grtx::sim {

/// Fewer groups are too few: a run's end, which is a few warps, is then much of the run.
inline constexpr std::uint64_t kFewestMeasuredGroups = 128;

/// Fewer node visits are too few: errors of single rays no longer cancel (up to 60 % was seen).
inline constexpr std::uint64_t kFewestMeasuredVisits = 3'000'000;

/// What of a machine and a trace of so many groups and node visits is outside, in words; empty: nothing. A number is
/// inside within a factor of four of its default, or of what the machines in configs/machines say.
std::string outside_of_measured(const GpuConfig& config, std::uint64_t groups, std::uint64_t visits);

/// What a result of that mode says of it. outside: as above.
ResultNotes outside_notes(std::string_view mode, const std::string& outside);

}  // namespace grtx::sim
