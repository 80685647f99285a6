// SPDX-License-Identifier: Apache-2.0
// Decides what happens to a hit: the resume rule, and how rounds of each kind of tracing collect hits. Paper, Listing 1
// (any hit) and docs/model/tracer.md.
#pragma once

#include <algorithm>
#include <optional>

#include "grtx/frontend/tracer/ray_state.h"
#include "grtx/frontend/tracer/tracer_options.h"
#include "grtx/traces/event.h"

namespace grtx::frontend {

class HitPolicy {
 public:
  explicit HitPolicy(const TracerOptions& options)
      : tracing_(options.tracing),
        resume_(options.resume),
        kth_(options.tmax_update == TmaxUpdate::kth),
        delayed_(options.any_hit == AnyHit::delayed),
        keep_evicted_(options.checkpoint) {}

  struct Taken {
    traces::LeafOutcome outcome;
    unsigned shifts = 0;  ///< entries of the k-buffer that moved
  };

  /// The resume rule: the outcome of a hit that is not after the last one blended; none: the hit is new.
  std::optional<traces::LeafOutcome> blended_before(const KEntry& hit, RayState& ray) const;
  /// Takes a new hit up to t_max. Delayed any-hit shaders take a ray's hits later, but in the order of this function's
  /// calls. As t_max does not move in between, what becomes of a hit is the same now as then.
  Taken take(const KEntry& hit, RayState& ray) const {
    if (traces::collects_unsorted(tracing_)) return collect_unsorted(hit, ray);
    if (tracing_ == Tracing::closest) return commit_nearest(hit, ray);
    return any_hit(hit, ray);
  }
  /// Begins a round: fills the k-buffer with the nearest entries of the eviction buffer; returns how many.
  std::size_t refill_from_evictions(RayState& ray) const;
  /// Ends a round: sorts its hits by (t, id).
  void finish(RayState& ray) const {
    if (traces::collects_unsorted(tracing_)) ray.k_buffer.sort();
  }

 private:
  /// The any-hit shader of multi-round tracing.
  Taken any_hit(const KEntry& hit, RayState& ray) const;
  Taken collect_unsorted(const KEntry& hit, RayState& ray) const;
  Taken commit_nearest(const KEntry& hit, RayState& ray) const;

  const Tracing tracing_;
  const Resume resume_;
  const bool kth_;           ///< t_max follows the last entry of a full k-buffer
  const bool delayed_;       ///< the traversal is over when a hit is taken: t_max stays
  const bool keep_evicted_;  ///< evicted entries go to the eviction buffer
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

inline HitPolicy::Taken HitPolicy::any_hit(const KEntry& hit, RayState& ray) const {
  using traces::LeafOutcome;
  KBuffer& buffer = ray.k_buffer;
  if (!buffer.full()) {
    const unsigned shifts = buffer.insert(hit);
    ++ray.counters.any_hit_inserted;
    if (kth_ && buffer.full() && !delayed_) ray.t_max = std::min(ray.t_max, buffer.back().t);
    return {LeafOutcome::inserted, shifts};
  }
  ++ray.counters.any_hit_evicted;
  if (hit < buffer.back()) {
    if (keep_evicted_) ray.evictions.push_back(buffer.back());
    const unsigned shifts = buffer.displace(hit);
    ++ray.counters.any_hit_inserted;
    if (kth_ && !delayed_) ray.t_max = std::min(ray.t_max, buffer.back().t);
    return {LeafOutcome::displaced, shifts};
  }
  if (keep_evicted_) ray.evictions.push_back(hit);
  ++ray.counters.any_hit_rejected;
  if (delayed_) return {LeafOutcome::rejected, 0};
  // A hit of an instance that is finished (BelowInstance) may lie beyond t_max.
  ray.t_max = std::min(ray.t_max, kth_ ? buffer.back().t : hit.t);
  return {LeafOutcome::rejected, 0};
}

/// Single-round and list tracing: hits are appended unsorted. A full buffer keeps the k nearest, and t_max shrinks as
/// in multi-round tracing, so that the next round finds the rejected hits behind the last one kept.
inline HitPolicy::Taken HitPolicy::collect_unsorted(const KEntry& hit, RayState& ray) const {
  using traces::LeafOutcome;
  KBuffer& buffer = ray.k_buffer;
  if (!buffer.full()) {
    const unsigned moved = buffer.append(hit);
    ++ray.counters.any_hit_inserted;
    if (kth_ && buffer.full()) ray.t_max = std::min(ray.t_max, buffer.largest().t);
    return {LeafOutcome::inserted, moved};
  }
  ray.turned_away = true;
  ++ray.counters.any_hit_evicted;
  if (hit < buffer.largest()) {
    const unsigned moved = buffer.replace_largest(hit);
    ++ray.counters.any_hit_inserted;
    if (kth_) ray.t_max = std::min(ray.t_max, buffer.largest().t);
    return {LeafOutcome::displaced, moved};
  }
  ++ray.counters.any_hit_rejected;
  ray.t_max = kth_ ? std::min(ray.t_max, buffer.largest().t) : hit.t;
  return {LeafOutcome::rejected, 0};
}

/// Closest-hit tracing: keeps only the nearest hit behind the last round's.
inline HitPolicy::Taken HitPolicy::commit_nearest(const KEntry& hit, RayState& ray) const {
  using traces::LeafOutcome;
  KBuffer& buffer = ray.k_buffer;
  if (buffer.full()) {
    if (!(hit < buffer.back())) return {LeafOutcome::beyond, 0};  // a tie with a smaller id
    buffer.displace(hit);
  } else {
    buffer.insert(hit);
  }
  ray.t_max = hit.t;
  ++ray.counters.nearest_commits;
  return {LeafOutcome::nearest, 0};
}

inline std::size_t HitPolicy::refill_from_evictions(RayState& ray) const {
  if (ray.evictions.empty()) return 0;
  std::sort(ray.evictions.begin(), ray.evictions.end());
  const std::size_t moved = std::min<std::size_t>(ray.k_buffer.capacity(), ray.evictions.size());
  for (std::size_t i = 0; i < moved; ++i) ray.k_buffer.append_sorted(ray.evictions[i]);
  ray.evictions.erase(ray.evictions.begin(), ray.evictions.begin() + static_cast<std::ptrdiff_t>(moved));
  return moved;
}

}  // namespace grtx::frontend
