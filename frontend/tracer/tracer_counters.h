// SPDX-License-Identifier: Apache-2.0
// Integer counters of the tracer: sums and maxima, so they do not depend on the number of threads. table() has the
// meaning of each and its name as a statistic.
#pragma once

#include <cstdint>
#include <optional>

#include "grtx/base/declare/counter_table.h"

namespace grtx::frontend {

/// Work that TracerOptions::opacity_bound has left out.
struct OpacityCounts {
  std::uint64_t rays = 0, hidden = 0, hits = 0, nodes = 0;
};

struct TracerCounters {
  std::uint64_t rays = 0, rounds = 0;
  std::uint64_t visits_internal = 0, visits_instance = 0, visits_leaf = 0;
  std::uint64_t visits_unique = 0;  ///< 0 unless asked for
  std::uint64_t any_hit_inserted = 0, any_hit_evicted = 0, any_hit_rejected = 0, any_hit_ignored = 0;
  std::uint64_t checkpoints_written = 0, checkpoints_read = 0, checkpoints_max_per_ray = 0, checkpoint_overflows = 0;
  std::uint64_t evictions_max_per_ray = 0;
  std::uint64_t processed = 0, blended = 0, terminated = 0;
  std::optional<std::uint64_t> hits;  ///< from count_hits(); unset unless asked for
  std::uint64_t ties_lost = 0, inside_skipped = 0;
  std::optional<OpacityCounts> opacity;  ///< unset unless the bound is on
  std::uint64_t single_overflows = 0, nearest_commits = 0, doubled = 0;
  // Work left out because it changes no bit of the image (docs/model/skips.md).
  std::uint64_t skipped_retests = 0, skipped_dead_colours = 0, skipped_sh_bands = 0, skipped_scene_misses = 0;
  std::uint64_t skipped_events = 0;

  std::uint64_t visits() const { return visits_internal + visits_instance + visits_leaf; }
  std::uint64_t any_hit_calls() const { return any_hit_inserted + any_hit_rejected + any_hit_ignored; }
  double ert_share() const;        ///< terminated / rays
  double hits_behind_end() const;  ///< hits / processed

  static const declare::CounterTable<TracerCounters>& table();
  void add(const TracerCounters& o) { table().add(*this, o); }
};

}  // namespace grtx::frontend
