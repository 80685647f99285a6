// The sums of a trace, round by round. Adding groups in any order gives the same totals.
#pragma once

#include <array>
#include <cstdint>
#include <iterator>
#include <span>

#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::traces {

/// Events of one round.
struct RoundCounts {
  std::uint64_t internal = 0;
  std::uint64_t instances = 0;
  std::uint64_t culls = 0;
  std::uint64_t read = 0;                 ///< source entries
  std::uint64_t written = 0;              ///< checkpoints
  std::array<std::uint64_t, 8> leaves{};  ///< by outcome

  /// Counts them all: none has been counted before.
  void count(std::span<const Event> events);
};

/// Counts one round. `in_eviction_buffer`: entries that the ray has there; 0 before its first round.
void count_round(const Header& header, const Round& round, const RoundCounts& counts, std::uint64_t& in_eviction_buffer,
                 Totals& totals);

/// Counts one group. Trusts the group; check() has its own count.
Totals count_totals(const Header& header, const RayGroup& group);

/// A total: its key in a trace's footer, and whether that of several groups is the largest, not the sum.
struct TotalField {
  const char* name;
  std::uint64_t Totals::*value;
  bool largest = false;
};
inline constexpr TotalField kTotalFields[] = {
    {"rays", &Totals::rays},
    {"rounds", &Totals::rounds},
    {"visits_internal", &Totals::visits_internal},
    {"visits_instance", &Totals::visits_instance},
    {"visits_leaf", &Totals::visits_leaf},
    {"culls", &Totals::culls},
    {"any_hit_calls", &Totals::any_hit_calls},
    {"evictions", &Totals::evictions},
    {"checkpoints_written", &Totals::checkpoints_written},
    {"checkpoints_read", &Totals::checkpoints_read},
    {"overflows", &Totals::overflows},
    {"processed", &Totals::processed},
    {"blended", &Totals::blended},
    {"max_checkpoints_per_round", &Totals::max_checkpoints_per_round, true},
    {"max_evictions_per_ray", &Totals::max_evictions_per_ray, true},
};
static_assert(sizeof(Totals) == std::size(kTotalFields) * sizeof(std::uint64_t), "every field");

/// Sums, and maxima of the largest.
void add_totals(Totals& to, const Totals& from);

}  // namespace grtx::traces
