// SPDX-License-Identifier: Apache-2.0
// The state that a ray carries from node to node and from round to round.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "grtx/frontend/tracer/checkpoint_buffers.h"
#include "grtx/frontend/tracer/k_buffer.h"
#include "grtx/frontend/tracer/tracer_counters.h"
#include "grtx/frontend/tracer/tracer_options.h"
#include "grtx/traces/rules/round_hits.h"

namespace grtx::frontend {

/// One per tracer, reused for each ray.
struct RayState {
  explicit RayState(const TracerOptions& options)
      : hits({options.tracing, options.any_hit, options.k, options.checkpoint, options.tmax_update == TmaxUpdate::kth},
             {options.opacity_bound, options.ert}),
        checkpoints(options) {
    if (options.opacity_bound == OpacityBound::on) counters.opacity.emplace();
  }

  /// before: transmittance at the ray's origin. limit: hits beyond it do not count.
  void begin_ray(float before, float limit) {
    t_last = -1.0f;
    id_last = 0;
    replay = false;
    transmittance = before;
    t_limit = t_given = limit;
    colour = glm::vec3(0.0f);
    hits.begin_ray();
    checkpoints.begin_ray();
    ++stamp;
    ++counters.rays;
  }

  /// Keeps an entry for the next round; false when it is dropped (checkpointing off, overflow, or beyond the end of the
  /// ray).
  bool checkpoint(const StackEntry& entry) {
    if (entry.t > t_limit || !checkpoints.write(entry, t_max)) return false;
    ++counters.checkpoints_written;
    return true;
  }

  /// Whether opacity has moved the end of the ray, and t lies behind it.
  bool ends_early() const { return t_limit < t_given; }
  bool is_hidden(float t) const { return t > t_limit && ends_early(); }

  float t_last = -1.0f;  ///< the last hit blended; -1 before the first
  std::uint32_t id_last = 0;
  float t_min_cull = 0.0f;  ///< boxes that end before this have no new hits
  float t_max = 0.0f;
  /// End of the ray: t_max at the start of a round; nothing beyond it is kept. Opacity may move it
  /// (TracerOptions::opacity_bound).
  float t_limit = 0.0f;
  float t_given = 0.0f;  ///< t_limit at the ray's start
  bool replay = false;
  bool turned_away = false;  ///< a hit of this round met a full k-buffer
  float transmittance = 1.0f;
  glm::vec3 colour{0.0f};
  traces::RoundHits<KEntry> hits;
  CheckpointBuffers checkpoints;
  std::uint64_t stamp = 0;  ///< number of the ray
  TracerCounters counters;  ///< of all rays so far
};

}  // namespace grtx::frontend
