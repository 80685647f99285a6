// The sums of a trace, round by round. Adding groups in any order gives the same totals.
#pragma once

#include <array>
#include <cstdint>
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

/// Sums, and maxima for the max_* members.
void add_totals(Totals& to, const Totals& from);

}  // namespace grtx::traces
