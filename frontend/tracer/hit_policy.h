// SPDX-License-Identifier: Apache-2.0
// Whether a hit is new (the resume rule), and what is counted of hits that are. What becomes of them is decided in
// traces/rules/round_rules.h. Paper, Listing 1 (any hit) and docs/model/tracer.md.
#pragma once

#include <optional>

#include "grtx/frontend/tracer/ray_state.h"
#include "grtx/frontend/tracer/tracer_options.h"
#include "grtx/traces/event.h"
#include "grtx/traces/rules/round_hits.h"

namespace grtx::frontend {

class HitPolicy {
 public:
  explicit HitPolicy(const TracerOptions& options) : tracing_(options.tracing), resume_(options.resume) {}

  /// The resume rule: the outcome of a hit that is not after the last one blended; none: the hit is new.
  std::optional<traces::LeafOutcome> blended_before(const KEntry& hit, RayState& ray) const;
  /// Takes a new hit up to t_max. Delayed any-hit shaders take a ray's hits later, but in the order of this function's
  /// calls. As t_max does not move in between, what becomes of a hit is the same now as then.
  static traces::RoundHits<KEntry>::Taken take(const KEntry& hit, RayState& ray) {
    const traces::RoundHits<KEntry>::Taken taken = ray.hits.take(hit, ray.t_max, ray.t_limit);
    TracerCounters& counters = ray.counters;
    if (taken.outcome == traces::LeafOutcome::nearest) {
      ++counters.nearest_commits;
    } else {
      counters.any_hit_inserted += traces::enters(taken.outcome) ? 1 : 0;
      counters.any_hit_rejected += taken.outcome == traces::LeafOutcome::rejected ? 1 : 0;
    }
    if (taken.hidden != 0) counters.opacity->hidden += taken.hidden;
    if (traces::evicts(taken.outcome)) {
      ++counters.any_hit_evicted;
      ray.turned_away = true;
    }
    return taken;
  }

 private:
  const Tracing tracing_;
  const Resume resume_;
};

inline std::optional<traces::LeafOutcome> HitPolicy::blended_before(const KEntry& hit, RayState& ray) const {
  using traces::LeafOutcome;
  if (hit.t < ray.t_last) return LeafOutcome::behind;
  if (hit.t > ray.t_last) return std::nullopt;
  if (resume_ == Resume::strict) {  // t_min < t fails: it never reaches the any-hit shader
    if (hit.id > ray.id_last) ++ray.counters.ties_lost;
    return LeafOutcome::behind;
  }
  if (hit.id > ray.id_last) return std::nullopt;
  if (tracing_ == Tracing::closest) return LeafOutcome::behind;
  ++ray.counters.any_hit_ignored;
  return LeafOutcome::ignored;
}

}  // namespace grtx::frontend
