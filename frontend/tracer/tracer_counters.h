// Integer counters of the tracer; sums and maxima, so they do not depend on the number of threads.
#pragma once

#include <algorithm>
#include <cstdint>

namespace grtx::frontend {

struct TracerCounters {
  std::uint64_t rays = 0;
  std::uint64_t rounds = 0;
  std::uint64_t visits_internal = 0;
  std::uint64_t visits_instance = 0;
  std::uint64_t visits_leaf = 0;
  std::uint64_t visits_unique = 0;     ///< distinct nodes a ray, summed; 0 unless asked for
  std::uint64_t any_hit_inserted = 0;  ///< inserted with room, or displacing the last entry
  std::uint64_t any_hit_evicted =
      0;  ///< entries that fell out of a full k-buffer (kept in the eviction buffer when checkpointing)
  std::uint64_t any_hit_rejected = 0;  ///< hits that did not fit
  std::uint64_t any_hit_ignored = 0;   ///< filtered by the exact resume rule
  std::uint64_t checkpoints_written = 0;
  std::uint64_t checkpoints_read = 0;
  std::uint64_t checkpoints_max_per_ray = 0;
  std::uint64_t checkpoint_overflows = 0;
  std::uint64_t evictions_max_per_ray = 0;
  std::uint64_t processed = 0;  ///< k-buffer entries looked at when blending
  std::uint64_t blended = 0;
  std::uint64_t ties_lost = 0;
  std::uint64_t inside_skipped = 0;
  std::uint64_t terminated = 0;  ///< rays that ended by early ray termination

  std::uint64_t single_overflows = 0;  ///< single: rounds in which a hit met a full buffer
  std::uint64_t nearest_commits = 0;   ///< closest: hits that became the nearest so far
  std::uint64_t doubled = 0;           ///< world triangle test: entries whose Gaussian the ray had processed before

  // What the skips left out (frontend/tracer/skips.h).
  std::uint64_t skipped_retests = 0;         ///< nodes that the ray had tested before
  std::uint64_t skipped_dead_colours = 0;    ///< colours of hits behind the one that ended a ray
  std::uint64_t skipped_sh_bands = 0;        ///< coefficients of a channel above the scene's degree
  std::uint64_t skipped_scene_misses = 0;    ///< rays that miss all boxes of the root
  std::uint64_t skipped_events = 0;          ///< visits that no trace asked for
  std::uint64_t skipped_never_accepted = 0;  ///< leaf or instance tests of Gaussians that cannot count
  std::uint64_t skipped_blas_walks = 0;      ///< instances decided at their leaf

  std::uint64_t visits() const { return visits_internal + visits_instance + visits_leaf; }
  std::uint64_t any_hit_calls() const { return any_hit_inserted + any_hit_rejected + any_hit_ignored; }

  void add(const TracerCounters& o) {
    rays += o.rays;
    rounds += o.rounds;
    visits_internal += o.visits_internal;
    visits_instance += o.visits_instance;
    visits_leaf += o.visits_leaf;
    visits_unique += o.visits_unique;
    any_hit_inserted += o.any_hit_inserted;
    any_hit_evicted += o.any_hit_evicted;
    any_hit_rejected += o.any_hit_rejected;
    any_hit_ignored += o.any_hit_ignored;
    checkpoints_written += o.checkpoints_written;
    checkpoints_read += o.checkpoints_read;
    checkpoints_max_per_ray = std::max(checkpoints_max_per_ray, o.checkpoints_max_per_ray);
    checkpoint_overflows += o.checkpoint_overflows;
    evictions_max_per_ray = std::max(evictions_max_per_ray, o.evictions_max_per_ray);
    processed += o.processed;
    blended += o.blended;
    ties_lost += o.ties_lost;
    inside_skipped += o.inside_skipped;
    terminated += o.terminated;
    single_overflows += o.single_overflows;
    nearest_commits += o.nearest_commits;
    doubled += o.doubled;
    skipped_retests += o.skipped_retests;
    skipped_dead_colours += o.skipped_dead_colours;
    skipped_sh_bands += o.skipped_sh_bands;
    skipped_scene_misses += o.skipped_scene_misses;
    skipped_events += o.skipped_events;
    skipped_never_accepted += o.skipped_never_accepted;
    skipped_blas_walks += o.skipped_blas_walks;
  }
};

}  // namespace grtx::frontend
