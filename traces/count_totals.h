// SPDX-License-Identifier: Apache-2.0
// Computes the totals of a trace. The order in which groups are added does not matter.
#pragma once

#include <array>
#include <cstdint>
#include <iterator>
#include <span>
#include <string>

#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::traces {

/// Events of one round.
struct RoundCounts {
  std::uint64_t internal = 0;
  std::uint64_t instances = 0;
  std::uint64_t culls = 0;
  std::uint64_t read = 0;                 ///< source entries read
  std::uint64_t written = 0;              ///< checkpoint entries written
  std::array<std::uint64_t, 8> leaves{};  ///< [LeafOutcome] leaf visits

  /// Counts all events of the round; call once.
  void count(std::span<const Event> events);
};

/// Adds one round to `totals`. in_eviction_buffer: the ray's current number of entries there; 0 before its first round.
void count_round(const Header& header, const Round& round, const RoundCounts& counts, std::uint64_t& in_eviction_buffer,
                 Totals& totals);

/// Totals of one group, which is assumed to be valid; check() counts independently.
Totals count_totals(const Header& header, const RayGroup& group);

/// A field of Totals: its key in the trace's footer, and whether groups are combined by maximum instead of sum.
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

/// Adds `from` to `to`: sums, or maxima for the fields marked `largest`.
void add_totals(Totals& to, const Totals& from);

/// As JSON text.
std::string totals_to_json(const Totals& totals);

}  // namespace grtx::traces
